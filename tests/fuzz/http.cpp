// What a server on the network sends: the input is all that it writes on every connection, before it closes it.
#include <netinet/in.h>
#include <sys/socket.h>

#include <mutex>
#include <thread>

#include "guard.h"
#include "records/json.h"
#include "remote/live.h"
#include "scratch.h"

namespace {

using namespace physmas;

class Server {
 public:
  Server() {
    unsetenv("http_proxy");
    setenv("PM_API_KEY", "key", 1);
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 16) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      std::perror("no socket to listen on");
      std::abort();
    }
    endpoint_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/v1";
    std::thread([this] { serve(); }).detach();
  }

  const std::string& endpoint() const { return endpoint_; }
  void answer(std::string bytes) {
    const std::lock_guard<std::mutex> lock(mutex_);
    bytes_ = std::move(bytes);
  }

 private:
  void serve() {
    for (;;) {
      const int connection = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (connection < 0) continue;
      char request[4096];  // longer than any of ours
      if (recv(connection, request, sizeof(request), 0) > 0) {
        // A client that gave up may be on its next request already.
        const std::string bytes = [this] {
          const std::lock_guard<std::mutex> lock(mutex_);
          return bytes_;
        }();
        send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        shutdown(connection, SHUT_WR);
        while (recv(connection, request, sizeof(request), 0) > 0) {
        }
      }
      close(connection);
    }
  }

  int listener_ = -1;
  std::string endpoint_;
  std::mutex mutex_;
  std::string bytes_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Scratch scratch;
  static Server& server = *new Server;  // its thread runs until the process ends
  server.answer(std::string(reinterpret_cast<const char*>(data), size));
  guard([&] {
    remote::RemoteOptions options;
    options.exchanges = scratch.folder();
    options.timeout = 5;
    options.budget = 0.5;  // a server that is not ready is waited for so long
    options.retries = 0;
    remote::LiveBackend backend(server.endpoint(), options);
    remote::Request request;
    request.name = "model_points";
    request.method = "POST";
    request.path = "/infer";
    request.body = {{"inputs", Json::array()}};
    request.returned_statuses = {404};
    request.reply_limit = 2048;
    backend.exchange(request);
  });
  return 0;
}
