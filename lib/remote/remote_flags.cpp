#include "base/command_line.h"
#include "remote/backend.h"

namespace physmas::remote {

void add_remote_options(Command app, RemoteOptions& options) {
  app.add_option("--exchanges", options.exchanges, "Folder for the recorded exchanges; default exchanges/ beside --out")
      .type_name("DIR")
      .group("Remote");
  app.add_option("--timeout", options.timeout, "Seconds for one reply")
      .between(0.05, 86400.0)
      .capture_default_str()
      .group("Remote");
  app.add_option("--budget", options.budget, "Seconds for all requests to one server, waiting included")
      .between(0.05, 864000.0)
      .capture_default_str()
      .group("Remote");
  app.add_option("--retries", options.retries,
                 "How often a request is sent again after 408, 429, 5xx or a lost connection")
      .between(0, 20)
      .capture_default_str()
      .group("Remote");
  app.add_option("--backoff", options.backoff, "Seconds before the first of these; doubles up to 30")
      .between(0.0, 60.0)
      .capture_default_str()
      .group("Remote");
}

}  // namespace physmas::remote
