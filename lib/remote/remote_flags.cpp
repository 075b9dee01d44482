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
                 "How often a request is sent again after 408, 429, 5xx or a lost connection; a server that "
                 "is not ready (503) is waited for within the budget")
      .between(0, 20)
      .capture_default_str()
      .group("Remote");
  app.add_option("--backoff", options.backoff, "Seconds before the first of these; doubles up to 30")
      .between(0.0, 60.0)
      .capture_default_str()
      .group("Remote");
  app.add_option(
         "--headers", options.headers,
         "File of further headers, a line \"Name: value\" each; ${NAME} is a variable of the environment. Values "
         "are kept nowhere")
      .type_name("FILE")
      .group("Remote");
}

void add_chat_options(Command app, RemoteOptions& options) {
  app.add_option(
         "--body", options.body,
         "JSON file of further fields of a chat request (max_tokens, chat_template_kwargs, ...); null takes one "
         "away")
      .type_name("FILE")
      .group("Remote");
}

void add_tensor_options(Command app, RemoteOptions& options) {
  app.add_option("--tensors", options.tensors,
                 "How an inference server gets and gives tensors; auto: JSON unless the model's metadata asks for the "
                 "binary extension")
      .one_of({"auto", "json", "binary"})
      .capture_default_str()
      .group("Remote");
}

}  // namespace physmas::remote
