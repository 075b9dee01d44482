// The three back ends behind one interface: built-in (none of this is used), remote (a model server), recorded
// (saved exchanges). Clients of a protocol (chat.h, inference.h) speak to a Backend and do not know which it is.
#ifndef PHYSMAS_REMOTE_BACKEND_H
#define PHYSMAS_REMOTE_BACKEND_H

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "remote/exchange.h"

namespace physmas {
class Command;
}

namespace physmas::remote {

class Backend {
 public:
  virtual ~Backend() = default;
  // Errors: exit code 4 when the provider fails, 3 when a recorded exchange does not fit the request.
  virtual Reply exchange(const Request& request) = 0;
  // Whether answers come from records, so that choices which a record holds need not be made again.
  virtual bool is_recorded() const = 0;
  // The record that will answer the request of that name: it knows how the question was put. Nothing from a server.
  virtual std::optional<ExchangeRecord> recorded(const std::string& name) const;
  // Every completed exchange so far, in order.
  const std::vector<ExchangeReference>& exchanges() const { return exchanges_; }

 protected:
  std::vector<ExchangeReference> exchanges_;
};

// Flags of every tool with a remote back end, of those that ask a chat server, and of those that ask an inference
// server.
struct RemoteOptions {
  std::string exchanges;         // folder in which exchanges are saved; empty: they are not
  double timeout = 120;          // seconds for one reply
  double budget = 1800;          // seconds for all requests to one server, waiting included
  int retries = 3;               // how often a request is sent again
  double backoff = 1;            // seconds before the first of these; doubles up to 30
  std::string headers;           // file of further headers (request_files.h)
  std::string body;              // file of further fields of chat requests (request_files.h)
  std::string tensors = "auto";  // how inference servers get tensors: auto | json | binary (inference.h)
};
void add_remote_options(Command app, RemoteOptions& options);
void add_chat_options(Command app, RemoteOptions& options);
void add_tensor_options(Command app, RemoteOptions& options);

enum class BackendKind { builtin, file, remote, recorded };

// What a flag such as --agent names: "replay:DIR" is recorded, anything with "://" is remote, one of `words` is
// builtin, the rest is a file.
BackendKind backend_kind(const std::string& text, const std::vector<std::string>& words);

// A back end for a remote or recorded `text`; its requests go to the URL's path plus Request::path. The key comes from
// the environment variable PM_API_KEY alone. flag: for messages, "--agent".
// endpoint_path: completes a URL without a path ("/v1").
std::unique_ptr<Backend> open_backend(const std::string& text, const std::string& flag,
                                      const std::string& endpoint_path, const RemoteOptions& options);

}  // namespace physmas::remote

#endif
