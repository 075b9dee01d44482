// One HTTP request over libcurl, with hard limits on time and size. No retries and no redirects: see live.h.
#ifndef PHYSMAS_REMOTE_HTTP_H
#define PHYSMAS_REMOTE_HTTP_H

#include <cstddef>
#include <memory>
#include <string>

namespace physmas::remote {

struct HttpRequest {
  std::string method;  // GET | POST
  std::string url;
  std::string body;        // sent as application/json when the method is POST
  std::string bearer;      // authorisation token, or empty
  double timeout = 0;      // seconds for the whole exchange
  size_t reply_limit = 0;  // bytes; a longer reply is refused as soon as that is known
};

struct HttpResult {
  enum class Outcome {
    answered,   // status, headers and the whole body are there
    broken,     // not connected, reset, or cut off: worth another try
    timed_out,  // within `timeout`
    too_large,  // above `reply_limit`
    refused     // anything else: bad certificate, unsupported scheme, ...
  } outcome = Outcome::refused;
  std::string why;  // unless answered
  int status = 0;
  std::string content_type;  // lower case, without parameters
  std::string location;      // absolute URL of a redirect, or empty
  double retry_after = 0;    // seconds that the server asks to wait, 0 when it does not say
  std::string body;
};

// Keeps its connection open between calls. Errors of the library's set-up are faults of ours (exit code 70).
class HttpClient {
 public:
  HttpClient();
  ~HttpClient();
  HttpResult send(const HttpRequest& request);

 private:
  struct Handle;
  std::unique_ptr<Handle> handle_;
};

// The parts of an http or https URL. `origin` is scheme://host:port. A malformed URL, another scheme, a user name, a
// query or a fragment is a usage Error (exit code 2) that shows no more of the URL than its host.
struct Url {
  std::string scheme, host, origin, path;  // path without a trailing slash
  bool is_loopback() const { return host == "localhost" || host == "127.0.0.1" || host == "[::1]"; }
};
Url parse_url(const std::string& url, const std::string& flag);

// scheme://host:port of an absolute URL; empty when it has none.
std::string origin_of(const std::string& url);

}  // namespace physmas::remote

#endif
