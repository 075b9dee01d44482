// The remote back end: retries with back-off, waiting for a server that is not ready, redirects, the total budget, and
// the record of every exchange.
#ifndef PHYSMAS_REMOTE_LIVE_H
#define PHYSMAS_REMOTE_LIVE_H

#include <string>

#include "base/clock.h"
#include "remote/address.h"
#include "remote/backend.h"
#include "remote/http.h"
#include "remote/key_mask.h"
#include "remote/request_files.h"

namespace physmas::remote {

class LiveBackend : public Backend {
 public:
  // endpoint: scheme://host:port/path?query. Reads PM_API_KEY and the file of headers; a key with control characters,
  // or a secret that stands in the endpoint, is a usage Error that does not show it.
  LiveBackend(std::string endpoint, const RemoteOptions& options);
  Reply exchange(const Request& request) override;
  bool is_recorded() const override { return false; }

 private:
  HttpResult answered(const Request& request, Json& attempts);
  HttpResult follow_redirects(HttpRequest request);
  bool is_loading(const Request& request, const HttpResult& result, Json& attempts);
  int probe(const std::string& address, size_t reply_limit, Json& attempts);
  bool waits_until_ready(const Request& request, const HttpResult& refusal, int& waits, Json& attempts);
  void check(const Request& request, const HttpResult& result) const;
  void wait(double seconds, const std::string& why);
  double backoff(int waits) const;
  double left() const { return options_.budget - watch_.seconds(); }
  HttpRequest http_request(const Request& request) const;
  void mask_headers(const std::vector<Header>& headers);
  // One line of a server's words, masked.
  std::string said_by(const HttpResult& result) const;

  std::string endpoint_;
  Url url_;
  std::string key_;
  std::vector<Header> headers_;
  KeyMasks secrets_;  // the key, and headers that are credentials
  KeyMasks masked_;   // these, and the other headers
  bool told_of_waiting_ = false;
  RemoteOptions options_;
  HttpClient http_;
  Stopwatch watch_;
};

}  // namespace physmas::remote

#endif
