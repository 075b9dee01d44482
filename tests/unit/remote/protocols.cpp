// Model protocols: what counts as an answer, as the same request, as a tensor, as an address.
#include <doctest/doctest.h>

#include "base/file.h"
#include "records/json.h"
#include "remote/base64.h"
#include "remote/chat.h"
#include "remote/http.h"
#include "remote/inference.h"
#include "remote/replay.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::remote;

namespace {

bool contains(const std::string& text, const std::string& part) {
  INFO(text);
  return text.find(part) != std::string::npos;
}

// A back end that answers from a list, and keeps the requests.
class Scripted : public Backend {
 public:
  explicit Scripted(std::vector<Reply> replies) : replies_(std::move(replies)) {}
  Reply exchange(const Request& request) override {
    requests.push_back(request);
    return replies_.at(requests.size() - 1);
  }
  bool is_recorded() const override { return false; }
  std::vector<Request> requests;

 private:
  std::vector<Reply> replies_;
};

Reply chat_reply(const std::string& content) {
  Json body;
  body["choices"] = Json::array({{{"message", {{"content", content}}}, {"finish_reason", "stop"}}});
  return {200, body};
}

const char* const kAbstains =
    R"({"key": "a/b", "abstain": true, "confidence": 0, "visible_views": [], "labels": [], "profiles": [],
        "statistics": {"E": null, "nu": null}})";

Question question() {
  Question q;
  q.name = "q";
  q.schema = "material_reply";
  q.images = {"PNG"};
  return q;
}

Json v2_reply(const Json& data, const Json& shape) {
  Json reply;
  reply["outputs"] = Json::array({{{"name", "x"}, {"datatype", "FP32"}, {"shape", shape}, {"data", data}}});
  return reply;
}

}  // namespace

TEST_CASE("remote: the JSON object in a model's text") {
  CHECK(object_in("{\"a\": 1}") == "{\"a\": 1}");
  CHECK(object_in("Sure!\n```json\n{\"a\": \"}\"}\n``` done {x}") == "{\"a\": \"}\"}");
  CHECK(object_in("<think>maybe {\"b\": 2}</think> {\"a\": {\"c\": \"\\\"}\"}}") == "{\"a\": {\"c\": \"\\\"}\"}}");
  CHECK(object_in("no object") == "");
  CHECK(object_in("{\"cut\": ") == "");
}

TEST_CASE("remote: base64 (RFC 4648, section 10)") {
  CHECK(base64_of("") == "");
  CHECK(base64_of("f") == "Zg==");
  CHECK(base64_of("foob") == "Zm9vYg==");
  CHECK(base64_of("foobar") == "Zm9vYmFy");
}

TEST_CASE("remote: requests are compared field by field; null matches anything") {
  const Json a = parse_json(R"({"m": null, "t": 0, "c": [{"x": "abc"}, 2]})", "a");
  const Json b = parse_json(R"({"m": "model", "t": 0, "c": [{"x": "abd"}, 2]})", "b");
  const auto found = first_difference(a, b);
  REQUIRE(found);
  CHECK(found->pointer == "/c/0/x");
  CHECK_FALSE(first_difference(a, a));
  CHECK(first_difference(parse_json("{}", "a"), parse_json("{\"n\": 1}", "b"))->pointer == "/n");
  CHECK(first_difference(parse_json("{\"n\": 1}", "a"), parse_json("{}", "b"))->recorded == "nothing");
  CHECK(first_difference(parse_json("[1]", "a"), parse_json("[1, 2]", "b"))->recorded == "2 entries");
}

TEST_CASE("remote: a record keeps the bytes of the reply and notices changes") {
  const TemporaryFolder folder;
  Request request;
  request.name = "q_1";
  request.method = "POST";
  request.body = {{"image", ""}, {"t", 0}};
  request.attachments = {{"/image", "data:image/png;base64,", "PNG", "png"}};
  CHECK(sent_body(request)["image"] == "data:image/png;base64,UE5H");
  ExchangeRecord record;
  record.name = request.name;
  record.method = request.method;
  record.url = "http://h/v1";
  record.request_body = recorded_body(request);
  record.attachments = {attachment_file(request.attachments[0])};
  record.status = 200;
  record.content_type = "application/json";
  record.body = "{ \"a\" : 1.50 }\n";
  save_exchange(folder / "", record, request);
  CHECK(load_exchange(folder / "q_1.json").body == record.body);
  CHECK(read_file(folder / record.attachments[0]) == "PNG");
  // Run times are not part of the hash.
  const std::string before = record.sha256();
  record.runtime["seconds"] = 3;
  CHECK(record.sha256() == before);

  ReplayBackend replay(folder / "", "--agent");
  CHECK(replay.exchange(request).body["a"] == 1.5);
  CHECK(replay.exchanges().size() == 1);
  request.body["t"] = 1;
  CHECK(contains(message_of([&] { replay.exchange(request); }), "/request/body/t: found 0 in the record, expected 1"));

  Json edited = parse_json(read_file(folder / "q_1.json"), "q");
  edited["request"]["url"] = "http://other/v1";
  write_file(folder / "q_1.json", edited.dump());
  CHECK(contains(message_of([&] { load_exchange(folder / "q_1.json"); }), "/sha256"));
}

TEST_CASE("remote: a question is asked again with the reason, and falls back to plain JSON") {
  Scripted server({{400, Json()}, chat_reply("I think it is foam."), chat_reply(kAbstains)});
  ChatClient chat(server, "m");
  const Answer answer = chat.ask(question());
  CHECK(answer.json["abstain"] == true);
  CHECK(answer.rejected == std::vector<std::string>{"it holds no JSON object"});
  REQUIRE(server.requests.size() == 3);
  CHECK(server.requests[0].body["response_format"]["json_schema"]["schema"]["additionalProperties"] == false);
  CHECK_FALSE(server.requests[1].body.contains("response_format"));
  CHECK(contains(server.requests[1].body["messages"][1]["content"][0]["text"].get<std::string>(), "JSON Schema"));
  CHECK(server.requests[2].body["messages"].size() == 3);
  CHECK(server.requests[2].body["temperature"] == 0);
  CHECK(server.requests[2].name == "q_3");
}

TEST_CASE("remote: refusals and withheld answers are the provider's failure") {
  Reply refusal = chat_reply("");
  refusal.body["choices"][0]["message"]["refusal"] = "I will not";
  Scripted server({refusal});
  ChatClient chat(server, "m");
  CHECK(contains(message_of([&] { chat.ask(question()); }, ExitCode::provider_failed), "I will not"));
}

TEST_CASE("remote: tensors, flat or nested, and what is wrong with them") {
  const std::vector<TensorSpecification> wanted = {{"x", {-1, 2}}};
  CHECK(tensors_from(v2_reply({1, 2, 3, 4}, {2, 2}), wanted, "s").at("x").numbers == std::vector<double>{1, 2, 3, 4});
  CHECK(tensors_from(v2_reply({{1, 2}, {3, 4}}, {2, 2}), wanted, "s").at("x").shape == std::vector<long>{2, 2});
  CHECK(std::isnan(tensors_from(v2_reply(Json::array({nullptr, 2}), {1, 2}), wanted, "s").at("x").numbers[0]));
  CHECK(tensors_from(v2_reply({1, 2}, {1, 2, 1}), wanted, "s").at("x").shape == std::vector<long>{1, 2});
  const auto error = [&](const Json& data, const Json& shape) {
    return message_of([&] { tensors_from(v2_reply(data, shape), wanted, "s"); }, ExitCode::provider_failed);
  };
  CHECK(contains(error({1, 2, 3}, {2, 2}), "found 3 numbers, expected 4"));
  CHECK(contains(error({1, 2, 3}, {1, 3}), "found [1, 3], expected [-1, 2]"));
  CHECK(contains(error({"a", 2}, {1, 2}), "expected numbers"));
  CHECK(contains(error({1, 2}, {1 << 26, 2}), "more than 2^26"));
  CHECK(contains(error({1, 2}, {-1, 2}), "expected extents"));
  CHECK(contains(message_of([&] { tensors_from(Json::object(), wanted, "s"); }, ExitCode::provider_failed),
                 "/outputs: found none"));
}

TEST_CASE("remote: addresses") {
  CHECK(parse_url("http://localhost:8000/v1/", "--agent").path == "/v1");
  CHECK(parse_url("https://host/v1", "--agent").origin == "https://host:443");
  CHECK(parse_url("http://[::1]:80", "--agent").is_loopback());
  CHECK_FALSE(parse_url("http://127.0.0.1.evil.org", "--agent").is_loopback());
  CHECK(origin_of("http://HOST/x") == origin_of("http://host:80/y"));
  CHECK(origin_of("/relative") == "");
  for (const char* bad : {"http://", "file:///etc/passwd", "http://u@h/", "http://h/?k=v", "http://h/#f", "http://h h/",
                          "http://h/\xff"}) {
    CAPTURE(bad);
    CHECK(contains(message_of([&] { parse_url(bad, "--agent"); }, ExitCode::usage), "--agent: found"));
  }
}
