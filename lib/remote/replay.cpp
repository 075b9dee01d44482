#include "remote/replay.h"

#include <filesystem>

namespace physmas::remote {

ReplayBackend::ReplayBackend(std::string folder, std::string flag)
    : folder_(std::move(folder)), flag_(std::move(flag)) {
  std::error_code failure;
  if (!std::filesystem::is_directory(folder_, failure)) {
    throw invalid_input({flag_ + " replay:" + folder_, "", "no such folder", "a folder of recorded exchanges"});
  }
}

Reply ReplayBackend::exchange(const Request& request) {
  const std::string path = (std::filesystem::path(folder_) / (request.name + ".json")).string();
  std::error_code failure;
  if (!std::filesystem::exists(path, failure)) {
    throw invalid_input(
        {path, "", "no such record", "the recorded exchange that this run needs", "record it with " + flag_ + " URL"});
  }
  const ExchangeRecord record = load_exchange(path);
  const auto differs = [&](const std::string& pointer, const std::string& now, const std::string& recorded) {
    return invalid_input({path, pointer, recorded + " in the record", now + ", as this run asks",
                          "the record belongs to other inputs or another version; record it again"});
  };
  if (record.name != request.name) throw differs("/name", request.name, record.name);
  if (record.method != request.method) throw differs("/request/method", request.method, record.method);
  if (const auto found = difference_from(record, request)) throw differs(found->pointer, found->now, found->recorded);
  Reply reply;
  reply.status = record.status;
  const bool success = record.status >= 200 && record.status < 300;
  if (success && request.wants_json) reply.body = parse_reply(record.body, path, request.loose_numbers);
  if (success) reply.binary = record.binary;
  if (!success) reply.said = record.body;
  exchanges_.push_back({record.name, record.sha256()});
  return reply;
}

std::optional<ExchangeRecord> ReplayBackend::recorded(const std::string& name) const {
  const std::string path = (std::filesystem::path(folder_) / (name + ".json")).string();
  std::error_code failure;
  if (!std::filesystem::exists(path, failure)) return std::nullopt;
  return load_exchange(path);
}

}  // namespace physmas::remote
