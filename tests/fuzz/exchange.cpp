// Recorded exchanges as a replay reads them. The record's two hashes are put right first, so that the fuzzer reaches
// what is behind them.
#include "base/hash.h"
#include "guard.h"
#include "records/json.h"
#include "remote/inference.h"
#include "remote/replay.h"
#include "scratch.h"

namespace {

using namespace physmas;

void fix_hashes(Json& document) {
  try {
    remote::ExchangeRecord record;
    const Json &request = document.at("request"), &response = document.at("response");
    record.method = request.at("method").get<std::string>();
    record.url = request.at("url").get<std::string>();
    record.request_body = request.at("body");
    record.attachments = request.at("attachments").get<std::vector<std::string>>();
    record.status = response.at("status").get<int>();
    record.content_type = response.at("content_type").get<std::string>();
    record.body = response.at("body").get<std::string>();
    document["response"]["sha256"] = sha256_text(record.body);
    document["sha256"] = record.sha256();
  } catch (const Json::exception&) {
    // Of another shape, which the reader has to find.
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Scratch scratch;
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::string fixed = text;
  try {
    Json document = parse_json(text, "input.json");
    fix_hashes(document);
    fixed = document.dump();
  } catch (const Error&) {
    // No JSON: so be it.
  }
  scratch.write("model_points.json", fixed);
  guard([&] {
    remote::ReplayBackend replay(scratch.folder(), "--tracker");
    remote::InferenceClient client(replay, "model");
    client.infer("points", {{"queries", {1, 2}, {}, {}, {1, 2}}}, {{"tracks", {1, -1}}, {"visibility", {-1}}});
  });
  return 0;
}
