// The remote back end: retries with back-off, redirects, the total budget, and the record of every exchange.
#ifndef PHYSMAS_REMOTE_LIVE_H
#define PHYSMAS_REMOTE_LIVE_H

#include <string>

#include "base/clock.h"
#include "remote/backend.h"
#include "remote/http.h"
#include "remote/key_mask.h"

namespace physmas::remote {

class LiveBackend : public Backend {
 public:
  // endpoint: scheme://host:port/path. Reads PM_API_KEY; one with control characters, or that stands in the endpoint,
  // is a usage Error that does not show it.
  LiveBackend(std::string endpoint, const RemoteOptions& options);
  Reply exchange(const Request& request) override;
  bool is_recorded() const override { return false; }

 private:
  HttpResult answered(const Request& request, const std::string& body, Json& attempts);
  HttpResult follow_redirects(HttpRequest request);
  void check(const Request& request, const HttpResult& result) const;
  void wait(double seconds, const std::string& why);
  double left() const { return options_.budget - watch_.seconds(); }

  std::string endpoint_;
  KeyMask key_;
  RemoteOptions options_;
  HttpClient http_;
  Stopwatch watch_;
};

}  // namespace physmas::remote

#endif
