// The recorded back end: answers requests from saved exchanges, byte for byte, without a network.
#ifndef PHYSMAS_REMOTE_REPLAY_H
#define PHYSMAS_REMOTE_REPLAY_H

#include <optional>
#include <string>

#include "remote/backend.h"

namespace physmas::remote {

class ReplayBackend : public Backend {
 public:
  // folder: of the records, as LiveBackend wrote them. One that is not there is an Error (exit code 3).
  ReplayBackend(std::string folder, std::string flag);
  // An Error (exit code 3) that names the first field which differs, when the record of that name is of another
  // request.
  Reply exchange(const Request& request) override;
  bool is_recorded() const override { return true; }
  std::optional<ExchangeRecord> recorded(const std::string& name) const override;

 private:
  std::string folder_;
  std::string flag_;
};

}  // namespace physmas::remote

#endif
