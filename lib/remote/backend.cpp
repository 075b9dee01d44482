#include "remote/backend.h"

#include <algorithm>

#include "remote/http.h"
#include "remote/live.h"
#include "remote/replay.h"

namespace physmas::remote {
namespace {

const std::string kReplay = "replay:";

}  // namespace

void add_remote_options(CLI::App& app, RemoteOptions& options) {
  app.add_option("--exchanges", options.exchanges, "Folder for the recorded exchanges; default exchanges/ beside --out")
      ->type_name("DIR")
      ->group("Remote");
  app.add_option("--timeout", options.timeout, "Seconds for one reply")
      ->check(CLI::Range(0.05, 86400.0))
      ->capture_default_str()
      ->group("Remote");
  app.add_option("--budget", options.budget, "Seconds for all requests to one server, waiting included")
      ->check(CLI::Range(0.05, 864000.0))
      ->capture_default_str()
      ->group("Remote");
  app.add_option("--retries", options.retries,
                 "How often a request is sent again after 408, 429, 5xx or a lost connection")
      ->check(CLI::Range(0, 20))
      ->capture_default_str()
      ->group("Remote");
  app.add_option("--backoff", options.backoff, "Seconds before the first of these; doubles up to 30")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str()
      ->group("Remote");
}

BackendKind backend_kind(const std::string& text, const std::vector<std::string>& words) {
  if (std::find(words.begin(), words.end(), text) != words.end()) return BackendKind::builtin;
  if (text.rfind(kReplay, 0) == 0) return BackendKind::recorded;
  return text.find("://") != std::string::npos ? BackendKind::remote : BackendKind::file;
}

std::unique_ptr<Backend> open_backend(const std::string& text, const std::string& flag,
                                      const std::string& endpoint_path, const RemoteOptions& options) {
  if (backend_kind(text, {}) == BackendKind::recorded)
    return std::make_unique<ReplayBackend>(text.substr(kReplay.size()), flag);
  const Url url = parse_url(text, flag);
  const std::string path = url.path.empty() ? endpoint_path : url.path;
  return std::make_unique<LiveBackend>(url.origin + path, options);
}

}  // namespace physmas::remote
