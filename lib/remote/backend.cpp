#include "remote/backend.h"

#include <algorithm>

#include "remote/address.h"
#include "remote/live.h"
#include "remote/replay.h"

namespace physmas::remote {
namespace {

const std::string kReplay = "replay:";

}  // namespace

std::optional<ExchangeRecord> Backend::recorded(const std::string&) const {
  return std::nullopt;
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
  return std::make_unique<LiveBackend>(url.origin + path + url.query, options);
}

}  // namespace physmas::remote
