// One HTTP request over libcurl, with hard limits on time and size. No retries and no redirects: see live.h.
#ifndef PHYSMAS_REMOTE_HTTP_H
#define PHYSMAS_REMOTE_HTTP_H

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace physmas::remote {

struct Header {
  std::string name, value;
};

struct HttpRequest {
  std::string method;  // GET | POST
  std::string url;
  std::string body;             // sent as application/json when the method is POST
  size_t json_length = 0;       // of the body's JSON where binary tensors follow it, else 0
  std::string bearer;           // authorisation token, or empty
  std::vector<Header> headers;  // of the user; an Authorization here stands instead of the token
  double timeout = 0;           // seconds for the whole exchange
  size_t reply_limit = 0;       // bytes; a longer reply is refused as soon as that is known
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
  size_t json_length = 0;    // of the body's JSON where binary tensors follow it, else 0
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

}  // namespace physmas::remote

#endif
