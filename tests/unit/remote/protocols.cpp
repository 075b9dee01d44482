// Model protocols: what counts as an answer, as the same request, as a tensor, as an address.
#include <doctest/doctest.h>

#include <cstdlib>
#include <sstream>

#include "base/file.h"
#include "records/json.h"
#include "records/validator.h"
#include "remote/address.h"
#include "remote/base64.h"
#include "remote/chat.h"
#include "remote/inference.h"
#include "remote/replay.h"
#include "remote/request_files.h"
#include "remote/tensor_bytes.h"
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
  explicit Scripted(std::vector<Reply> all) : replies(std::move(all)) {}
  Reply exchange(const Request& request) override {
    requests.push_back(request);
    return replies.at(requests.size() - 1);
  }
  bool is_recorded() const override { return false; }
  std::vector<Request> requests;
  std::vector<Reply> replies;
};

Reply refusal(int status, const std::string& said) {
  Reply reply;
  reply.status = status;
  reply.said = said;
  return reply;
}

Reply chat_reply(const std::string& content) {
  Json body;
  body["choices"] = Json::array({{{"message", {{"content", content}}}, {"finish_reason", "stop"}}});
  Reply reply;
  reply.status = 200;
  reply.body = body;
  return reply;
}

const char* const kAbstains =
    R"({"key": "a/b", "abstain": true, "confidence": 0, "visible_views": [], "labels": [], "profiles": [],
        "statistics": {"E": null, "nu": null}})";

Question question() {
  Question q;
  q.name = "q";
  q.schema = "material_reply";
  q.images = {"PNG"};
  q.given = {{"/properties/key", {{"enum", {"a/b"}}}}};
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
  CHECK(object_in("<think>maybe {\"b\": 2}") == "");
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
  Scripted server({refusal(400, ""), refusal(400, ""), chat_reply("I think it is foam."), chat_reply(kAbstains)});
  ChatClient chat(server, "m");
  const Answer answer = chat.ask(question());
  CHECK(answer.json["abstain"] == true);
  CHECK(answer.rejected == std::vector<std::string>{"it holds no JSON object"});
  REQUIRE(server.requests.size() == 4);
  const Json schema = server.requests[0].body["response_format"]["json_schema"]["schema"];
  CHECK(schema["additionalProperties"] == false);
  CHECK(schema["properties"]["key"] == parse_json(R"({"enum": ["a/b"]})", "key"));
  CHECK(server.requests[1].body["response_format"] == Json({{"type", "json_object"}}));
  CHECK_FALSE(server.requests[2].body.contains("response_format"));
  // The schema stands in the text from the first on: a server may ignore it elsewhere.
  for (const Request& request : server.requests)
    CHECK(contains(request.body["messages"][1]["content"][0]["text"].get<std::string>(), "JSON Schema"));
  // User and assistant take turns.
  const Json& messages = server.requests[3].body["messages"];
  REQUIRE(messages.size() == 4);
  CHECK(messages[2] == Json({{"role", "assistant"}, {"content", "I think it is foam."}}));
  CHECK(messages[3]["role"] == "user");
  CHECK(server.requests[3].body["temperature"] == 0);
  CHECK(server.requests[3].name == "q_4");
  CHECK(server.requests[3].manner["structure"] == "text");
  // What was found out counts for the next question.
  server.replies = {chat_reply(kAbstains)};
  server.requests.clear();
  chat.ask(question());
  CHECK_FALSE(server.requests[0].body.contains("response_format"));
}

TEST_CASE("remote: what a server refuses by name is left out, once") {
  Scripted server({refusal(400, "Unsupported value: 'temperature' does not support 0 with this model"),
                   refusal(400, "Unsupported parameter: 'max_tokens'. Use 'max_completion_tokens' instead"),
                   refusal(400, "parameter.enable_thinking must be set to false for non-streaming calls"),
                   refusal(400, "System role not supported"), chat_reply(kAbstains)});
  ChatClient chat(server, "m", {{"max_tokens", 500}, {"seed", 7}});
  chat.ask(question());
  REQUIRE(server.requests.size() == 5);
  CHECK(server.requests[0].body["max_tokens"] == 500);
  const Json& body = server.requests[4].body;
  CHECK_FALSE(body.contains("temperature"));
  CHECK_FALSE(body.contains("max_tokens"));
  CHECK(body["max_completion_tokens"] == 500);
  CHECK(body["seed"] == 7);
  CHECK(body["enable_thinking"] == false);
  CHECK(body["chat_template_kwargs"] == Json({{"enable_thinking", false}}));
  CHECK(body["messages"].size() == 1);
  CHECK(body["response_format"]["type"] == "json_schema");
  CHECK(server.requests[4].attachments[0].pointer == "/messages/0/content/1/image_url/url");
  // And if it does not know what it asked for either, that is left out.
  Scripted strict({refusal(400, "thinking is on"), refusal(400, "Unrecognized argument: enable_thinking"),
                   refusal(400, "thinking is on"), chat_reply(kAbstains)});
  ChatClient(strict, "m").ask(question());
  CHECK_FALSE(strict.requests[2].body.contains("enable_thinking"));
  CHECK(strict.requests[3].body["response_format"]["type"] == "json_object");
}

TEST_CASE("remote: refusals that no other way of asking helps end at once, with the server's words") {
  for (const Reply& reply :
       {refusal(404, R"({"error": {"message": "The model `m` does not exist."}})"),
        refusal(400, R"({"error": {"message": "image input is not supported - provide the mmproj"}})"),
        refusal(422, R"({"detail": [{"msg": "not a multimodal model"}]})")}) {
    Scripted server({reply});
    ChatClient chat(server, "m");
    CHECK(contains(message_of([&] { chat.ask(question()); }, ExitCode::provider_failed), words_of(reply.said)));
    CHECK(server.requests.size() == 1);
  }
}

TEST_CASE("remote: an answer in parts, or where thoughts belong; thoughts are no answer") {
  Reply parts = chat_reply("");
  parts.body["choices"][0]["message"]["content"] =
      Json::array({{{"type", "thinking"}, {"text", "{\"draft\": 1}"}}, {{"type", "text"}, {"text", kAbstains}}});
  CHECK(said_in(parts.body, "q").answer == kAbstains);
  for (const char* field : {"reasoning", "reasoning_content"}) {
    Reply reply = chat_reply("");
    Json& message = reply.body["choices"][0]["message"];
    message["content"] = Json();
    message[field] = kAbstains;
    CHECK(said_in(reply.body, "q").answer == kAbstains);
    message[field] = std::string("I could say ") + kAbstains;
    CHECK(said_in(reply.body, "q").answer.empty());
    message["content"] = "yes";
    message[field] = kAbstains;
    CHECK(said_in(reply.body, "q").answer == "yes");
  }
  // A model that only thinks is asked again without.
  Reply thinking = chat_reply("<think>maybe {\"key\": 1}");
  thinking.body["choices"][0]["finish_reason"] = "length";
  Scripted server({thinking, chat_reply(kAbstains)});
  CHECK(ChatClient(server, "m").ask(question()).rejected.empty());
  CHECK_FALSE(server.requests[0].body.contains("enable_thinking"));
  CHECK(server.requests[1].body["enable_thinking"] == false);
  Scripted stubborn({thinking, thinking});
  CHECK(contains(message_of([&] { ChatClient(stubborn, "m").ask(question()); }, ExitCode::provider_failed), "cut off"));
}

TEST_CASE("remote: what a user adds to a request, and takes away") {
  const TemporaryFolder folder;
  write_file(folder / "b.json", R"({"temperature": null, "top_k": 1})");
  Scripted server({chat_reply(kAbstains)});
  ChatClient(server, "m", load_body_fields(folder / "b.json")).ask(question());
  CHECK_FALSE(server.requests[0].body.contains("temperature"));
  CHECK(server.requests[0].body["top_k"] == 1);
  CHECK(server.requests[0].added == std::vector<std::string>{"temperature", "top_k"});
  for (const char* bad : {R"({"messages": []})", R"({"model": "x"})", "[]", "{"}) {
    write_file(folder / "b.json", bad);
    CHECK(contains(message_of([&] { load_body_fields(folder / "b.json"); }), "b.json"));
  }
  CHECK(load_body_fields("").is_null());
}

TEST_CASE("remote: a record is asked for as it was asked, also one of an earlier version") {
  const TemporaryFolder folder;
  const auto record_of = [&](const Request& request, const Reply& reply) {
    ExchangeRecord record;
    record.name = request.name;
    record.method = request.method;
    record.url = "http://h/v1";
    record.request_body = recorded_body(request);
    for (const Attachment& a : request.attachments) record.attachments.push_back(attachment_file(a));
    record.added = request.added;
    record.manner = request.manner;
    record.status = reply.status;
    record.body = reply.status == 200 ? reply.body.dump() : reply.said;
    save_exchange(folder / "", record, request);
  };
  const std::vector<Reply> replies = {refusal(400, "no temperature"), refusal(400, "no json_schema"), chat_reply("hm"),
                                      chat_reply(kAbstains)};
  Scripted server(replies);
  ChatClient(server, "m", {{"top_k", 1}}).ask(question());
  for (size_t i = 0; i < replies.size(); ++i) record_of(server.requests[i], replies[i]);
  ReplayBackend replay(folder / "", "--agent");
  // Without the added fields, and without the model's name.
  CHECK(ChatClient(replay, "").ask(question()).rejected.size() == 1);
  CHECK(replay.exchanges().size() == 4);
  CHECK(ChatClient(replay, "m", {{"top_k", 1}}).ask(question()).json["abstain"] == true);
  CHECK(contains(message_of([&] { ChatClient(replay, "m", {{"top_k", 2}}).ask(question()); }), "/request/body/top_k"));

  // As version 0.1 asked: the schema in the text only where it was refused elsewhere, the correction after the
  // question.
  Json plain = schema_document("material_reply");
  plain.erase("$schema");
  Json old = server.requests[0].body;
  old.erase("top_k");
  std::string& text = old["messages"][1]["content"][0]["text"].get_ref<std::string&>();
  const std::string with_schema = question().text +
                                  "\n\nReply with one JSON object and nothing else. It must fit this JSON Schema:\n" +
                                  plain.dump();
  text = question().text;
  old["response_format"]["json_schema"]["schema"] = plain;
  Request first = server.requests[0];
  first.added.clear();
  first.manner = Json();
  first.body = old;
  record_of(first, refusal(400, "no"));
  old.erase("response_format");
  text = with_schema;
  Request second = first, third = first;
  second.name = "q_2";
  second.body = old;
  record_of(second, chat_reply("hm"));
  third.name = "q_3";
  old["messages"].push_back(
      {{"role", "user"},
       {"content", "Your last answer was rejected: it holds no JSON object. Answer the question again."}});
  third.body = old;
  record_of(third, chat_reply(kAbstains));
  ReplayBackend earlier(folder / "", "--agent");
  CHECK(ChatClient(earlier, "m").ask(question()).rejected.size() == 1);
  CHECK(earlier.exchanges().size() == 3);
}

TEST_CASE("remote: a server's words") {
  CHECK(words_of(R"({"error": {"message": "Loading model", "code": 503}})") == "Loading model");
  CHECK(words_of(R"({"error": "out of memory"})") == "out of memory");
  CHECK(words_of(R"({"detail": "Not Found"})") == "Not Found");
  CHECK(words_of("<html><body>Please  log\nin</body></html>") == "Please log in");
  CHECK(words_of("") == "");
  const std::string traceback = "Traceback: " + std::string(5000, '.') + " IndexError: no such index";
  CHECK(words_of(traceback).size() <= 330);
  CHECK(contains(words_of(traceback), "Traceback: "));
  CHECK(contains(words_of(traceback), "IndexError: no such index"));
}

TEST_CASE("remote: refusals and withheld answers are the provider's failure") {
  Reply refused = chat_reply("");
  refused.body["choices"][0]["message"]["refusal"] = "I will not";
  Scripted server({refused});
  ChatClient chat(server, "m");
  CHECK(contains(message_of([&] { chat.ask(question()); }, ExitCode::provider_failed), "I will not"));
}

TEST_CASE("remote: tensors, flat or nested, and what is wrong with them") {
  const std::vector<TensorSpecification> wanted = {{"x", {-1, 2}}}, loose = {{"x", {-1, 2}, true}};
  CHECK(tensors_from(v2_reply({1, 2, 3, 4}, {2, 2}), wanted, "s").at("x").numbers == std::vector<double>{1, 2, 3, 4});
  CHECK(tensors_from(v2_reply({{1, 2}, {3, 4}}, {2, 2}), wanted, "s").at("x").shape == std::vector<long>{2, 2});
  CHECK(std::isnan(tensors_from(v2_reply(Json::array({nullptr, 2}), {1, 2}), loose, "s").at("x").numbers[0]));
  const auto error = [&](const Json& data, const Json& shape) {
    return message_of([&] { tensors_from(v2_reply(data, shape), wanted, "s"); }, ExitCode::provider_failed);
  };
  CHECK(contains(error({nullptr, 2}, {1, 2}), "/outputs/x/data/0: found NaN"));
  CHECK(contains(error({1, 2, 3}, {2, 2}), "found 3 numbers, expected 4"));
  CHECK(contains(error({1, 2, 3}, {1, 3}), "found [1, 3], expected [-1, 2]"));
  CHECK(contains(error({"a", 2}, {1, 2}), "expected numbers"));
  CHECK(contains(error({1, 2}, {1 << 26, 2}), "more than 2^26"));
  CHECK(contains(error({1, 2}, {-1, 2}), "expected extents"));
  CHECK(contains(message_of([&] { tensors_from(Json::object(), wanted, "s"); }, ExitCode::provider_failed),
                 "/outputs: found none"));
  CHECK(contains(message_of(
                     [&] {
                       tensors_from({{"error", "CUDA out of memory"}}, wanted, "s");
                     },
                     ExitCode::provider_failed),
                 "CUDA out of memory"));
}

TEST_CASE("remote: extents of 1 in front and behind do not count") {
  const auto shape = [](const std::vector<long>& wanted, const Json& found) {
    long elements = 1;
    for (const Json& extent : found) elements *= extent.get<long>();
    return tensors_from(v2_reply(std::vector<int>(static_cast<size_t>(elements), 1), found), {{"x", wanted}}, "s")
        .at("x")
        .shape;
  };
  using Shape = std::vector<long>;
  CHECK(shape({-1, 2}, {1, 3, 2}) == Shape{3, 2});
  CHECK(shape({-1, 2}, {1, 1, 3, 2}) == Shape{3, 2});
  CHECK(shape({-1, 2}, {3, 2, 1}) == Shape{3, 2});
  CHECK(shape({-1, 2}, {1, 1, 2}) == Shape{1, 2});
  CHECK(shape({-1}, {1, 5}) == Shape{5});
  CHECK(shape({-1}, {5, 1}) == Shape{5});
  CHECK(shape({-1}, {1, 1}) == Shape{1});
  CHECK(shape({1, -1}, {7}) == Shape{1, 7});
  CHECK(shape({1, 4, 3, 2}, {4, 3, 2}) == Shape{1, 4, 3, 2});
  CHECK(shape({2, 3, 3}, {1, 2, 3, 3}) == Shape{2, 3, 3});
  CHECK(shape({-1, 4}, {1, 0, 4}) == Shape{0, 4});
  CHECK(contains(message_of([&] { shape({-1, 2}, {2, 3, 2}); }, ExitCode::provider_failed), "found [2, 3, 2]"));
}

TEST_CASE("remote: an input goes in the shape that the model declares") {
  const auto shape = [](const std::vector<long>& ours, const std::vector<long>& theirs) {
    const DeclaredTensor declared{"x", "FP32", theirs};
    return shape_for(ours, &declared);
  };
  using Shape = std::vector<long>;
  CHECK(shape({5, 4}, {-1, -1, 4}) == Shape{1, 5, 4});
  CHECK(shape({1}, {-1, -1}) == Shape{1, 1});
  CHECK(shape({3}, {-1, 1}) == Shape{3, 1});
  CHECK(shape({3}, {-1, -1}) == Shape{1, 3});
  CHECK(shape({3}, {-1}) == Shape{3});
  CHECK(shape({3}, {-1, -1, -1, 3}) == Shape{3});
  CHECK(shape_for({3}, nullptr) == Shape{3});
}

TEST_CASE("remote: NaN and Infinity, which are no JSON, are missing numbers; texts keep them") {
  const std::string text =
      R"({"outputs": [{"name": "x", "datatype": "FP32", "shape": [4], "data": [NaN, -Infinity, 1, Infinity]}], "s": "NaN \" NaN"})";
  const Json reply = parse_reply(text, "s", true);
  CHECK(reply["s"] == "NaN \" NaN");
  CHECK(reply["outputs"][0]["data"] == Json::array({nullptr, nullptr, 1, nullptr}));
  CHECK(contains(message_of(
                     [&] {
                       tensors_from(reply, {{"x", {-1}}}, "s");
                     },
                     ExitCode::provider_failed),
                 "/outputs/x/data/0: found NaN"));
  CHECK(tensors_from(reply, {{"x", {-1}, true}}, "s").at("x").numbers[2] == 1);
  CHECK(contains(message_of([&] { parse_reply(text, "s"); }, ExitCode::provider_failed), "malformed JSON"));
}

TEST_CASE("remote: binary tensors of every datatype") {
  for (const char* type : {"BOOL", "UINT8", "UINT16", "UINT32", "UINT64", "INT8", "INT16", "INT32", "INT64", "FP16",
                           "BF16", "FP32", "FP64"}) {
    CAPTURE(type);
    const std::vector<double> numbers = {0, 1, 1, 0};
    const std::string bytes = bytes_of(numbers, type);
    CHECK(bytes.size() == 4 * element_size(type));
    CHECK(numbers_in(bytes, type) == numbers);
  }
  CHECK(bytes_of(std::vector<double>{1.5, -2}, "FP16") == std::string("\x00\x3e\x00\xc0", 4));
  CHECK(bytes_of(std::vector<double>{1.5}, "BF16") == std::string("\xc0\x3f", 2));
  CHECK(numbers_in(std::string("\xfe\xff\xff\xff", 4), "INT32") == std::vector<double>{-2});
  CHECK(element_size("BYTES") == 0);
  std::vector<std::string> texts;
  CHECK(texts_in(bytes_of(std::vector<std::string>{"ab", "", std::string("\0c", 2)}), texts));
  CHECK(texts == std::vector<std::string>{"ab", "", std::string("\0c", 2)});
  CHECK_FALSE(texts_in(std::string("\x05\0\0\0ab", 6), texts));
  CHECK_FALSE(texts_in("ab", texts));
}

TEST_CASE("remote: binary outputs follow the JSON in their order") {
  const std::string behind = bytes_of(std::vector<double>{9, 9}, "FP32") + bytes_of(std::vector<double>{1, 2}, "FP16");
  Json reply = parse_json(R"({"outputs": [
    {"name": "other", "datatype": "FP32", "shape": [2], "parameters": {"binary_data_size": 8}},
    {"name": "x", "datatype": "FP16", "shape": [1, 2], "parameters": {"binary_data_size": 4}}]})",
                          "r");
  const std::vector<TensorSpecification> wanted = {{"x", {-1}}};
  CHECK(tensors_from(reply, wanted, "s", behind).at("x").numbers == std::vector<double>{1, 2});
  const auto error = [&] {
    return message_of([&] { tensors_from(reply, wanted, "s", behind); }, ExitCode::provider_failed);
  };
  Json& size = reply["outputs"][1]["parameters"]["binary_data_size"];
  size = 5U;
  CHECK(contains(error(), "found 4 bytes behind the JSON, expected 5"));
  size = 2U;
  CHECK(contains(error(), "/outputs/x/parameters/binary_data_size: found 2 bytes, expected 4"));
  size = -4;
  CHECK(contains(error(), "expected a number of bytes"));
  size = 4U;
  reply["outputs"][1]["datatype"] = "FP8";
  CHECK(contains(error(), "FP8"));
  reply["outputs"][1] = {{"name", "x"}, {"datatype", "FP32"}, {"shape", {1}}, {"data", {3}}};
  CHECK(tensors_from(reply, wanted, "s", behind).at("x").numbers == std::vector<double>{3});
}

TEST_CASE("remote: a request's JSON does not hold what is sent behind it; its record does") {
  Request request;
  request.method = "POST";
  request.body = parse_json(R"({"inputs": [{"name": "i", "data": ["", 2]}, {"name": "n", "data": [1]}]})", "b");
  request.attachments = {{"/inputs/0/data/0", "", "PNG", "png"}};
  request.parts = {{"/inputs/0/data", "BYTES"}};
  const RequestBytes sent = request_bytes(request);
  CHECK(sent.bytes == R"({"inputs":[{"name":"i"},{"name":"n","data":[1]}]}BYTES)");
  CHECK(sent.json_length == sent.bytes.size() - 5);
  CHECK(contains(recorded_body(request)["inputs"][0]["data"][0].get<std::string>(), "sha256:"));
  request.parts.clear();
  CHECK(request_bytes(request).json_length == 0);
}

TEST_CASE("remote: what follows the JSON lies beside the record, and changes are noticed") {
  const TemporaryFolder folder;
  Request request;
  request.name = "q";
  request.method = "POST";
  ExchangeRecord record;
  record.name = "q";
  record.method = "POST";
  record.status = 200;
  record.body = "{}";
  record.binary = std::string("\0\xff", 2);
  record.headers = {"X-Tenant"};
  save_exchange(folder / "", record, request);
  const std::string text = read_file(folder / "q.json");
  CHECK(contains(text, "\"X-Tenant\": \"[masked]\""));
  CHECK(load_exchange(folder / "q.json").binary == record.binary);
  CHECK(load_exchange(folder / "q.json").headers == record.headers);
  CHECK(ReplayBackend(folder / "", "--agent").exchange(request).binary == record.binary);
  const size_t at = text.find(".bin");
  write_file(folder / text.substr(at - 64, 68), "ab");
  CHECK(contains(message_of([&] { load_exchange(folder / "q.json"); }), "other bytes than its name says"));
}

TEST_CASE("remote: a model says nothing of its tensors, or calls its only ones otherwise") {
  const auto metadata = [](const char* text) {
    Reply reply;
    reply.status = 200;
    reply.body = parse_json(text, "m");
    return reply;
  };
  Reply empty;
  empty.status = 200;
  Scripted silent({empty, metadata(R"({"name": "m", "inputs": [], "outputs": []})"),
                   metadata(R"({"outputs": [{"name": "y", "datatype": "FP32", "shape": [1], "data": [2]}]})")});
  InferenceClient client(silent, "c");
  client.require_model({"x"}, {"y"});
  CHECK(client.infer("i", {{"x", {1}, {}, {}, {1.5}}}, {{"y", {-1}}}).at("y").numbers[0] == 2);
  CHECK(silent.requests[2].body["inputs"][0]["datatype"] == "FP32");

  Scripted other(
      {empty,
       metadata(
           R"({"inputs": [{"name": "INPUT0", "datatype": "FP16", "shape": [-1, -1]}], "outputs": [{"name": "OUTPUT0", "datatype": "FP16", "shape": [-1]}]})"),
       metadata(R"({"outputs": [{"name": "OUTPUT0", "datatype": "FP32", "shape": [1, 1], "data": [2]}]})")});
  InferenceClient half(other, "c");
  half.require_model({"x"}, {"y"});
  CHECK(half.infer("i", {{"x", {1}, {}, {}, {1.5}}}, {{"y", {-1}}}).at("y").numbers[0] == 2);
  const Request& request = other.requests[2];
  CHECK(request.body["inputs"][0]["name"] == "INPUT0");
  CHECK(request.body["inputs"][0]["datatype"] == "FP16");
  CHECK(request.body["inputs"][0]["shape"] == Json({1, 1}));
  CHECK(request.body["outputs"][0] == parse_json(R"({"name": "OUTPUT0", "parameters": {"binary_data": true}})", "o"));
  REQUIRE(request.parts.size() == 1);
  CHECK(request.parts[0].bytes == std::string("\x00\x3e", 2));

  Scripted wrong({empty, metadata(R"({"inputs": [{"name": "a"}, {"name": "b"}]})")});
  InferenceClient lost(wrong, "c");
  CHECK(contains(message_of([&] { lost.require_model({"x"}, {"y"}); }, ExitCode::provider_failed),
                 "/inputs: found \"a\", \"b\", expected \"x\""));
  // OpenVINO's server takes pictures as binary only.
  Scripted openvino(
      {empty,
       metadata(R"({"platform": "OpenVINO", "inputs": [{"name": "x", "datatype": "FP32", "shape": [-1, -1, -1, 3]}]})"),
       metadata(R"({"outputs": [{"name": "y", "datatype": "FP32", "shape": [1], "data": [2]}]})")});
  InferenceClient pictures(openvino, "c");
  pictures.require_model({"x"}, {"y"});
  pictures.infer("i", {{"x", {1}, {"PNG"}, {}, {}}}, {{"y", {-1}}});
  CHECK(openvino.requests[2].body["inputs"][0]["datatype"] == "BYTES");
  CHECK(openvino.requests[2].parts[0].bytes == std::string("\x03\0\0\0PNG", 7));
}

TEST_CASE("remote: headers of a file") {
  const TemporaryFolder folder;
  const auto headers = [&](const std::string& text) {
    write_file(folder / "h", text);
    return load_request_headers(folder / "h");
  };
  setenv("PM_TEST_HEADER", "from the environment", 1);
  const RequestHeaders some = headers("# comment\r\n\nHost: models.example\r\nX-Tenant:  ${PM_TEST_HEADER} \n");
  REQUIRE(some.headers.size() == 2);
  CHECK(some.headers[1].name == "X-Tenant");
  CHECK(some.headers[1].value == "from the environment");
  CHECK_FALSE(some.holds_key);
  setenv("PM_API_KEY", "pmkey", 1);
  CHECK(headers("api-key: ${PM_API_KEY}").holds_key);
  unsetenv("PM_API_KEY");
  for (const char* bad :
       {"no header secret1", "X Y: secret1", "Content-Length: 5", "transfer-encoding: secret1",
        "A: secret1\nA: secret1", "A: ${secret1}", "A: ${secret1", "A:", "A: secret1\x01", "A: secret1\xc3\xa4"}) {
    CAPTURE(bad);
    const std::string message = message_of([&] { headers(bad); });
    CHECK(contains(message, "line "));
    CHECK_FALSE(contains(message, "secret1"));
  }
  CHECK(secrecy_of({"Authorization", "x"}) == Secrecy::secret);
  CHECK(secrecy_of({"Ocp-Apim-Subscription-Key", "x"}) == Secrecy::secret);
  CHECK(secrecy_of({"X-Whatever", "AbCdEfGhIjKlMnOpQrSt1"}) == Secrecy::secret);
  CHECK(secrecy_of({"X-Tenant", "physics"}) == Secrecy::masked);
  CHECK(secrecy_of({"X-Tenant", "a"}) == Secrecy::open);
  CHECK(secrecy_of({"Host", "models.example"}) == Secrecy::open);
}

TEST_CASE("remote: addresses") {
  CHECK(parse_url("http://localhost:8000/v1/", "--agent").path == "/v1");
  CHECK(parse_url("https://host/v1", "--agent").origin == "https://host:443");
  CHECK(parse_url("https://host/v1?api-version=2024-10-21", "--agent").query == "?api-version=2024-10-21");
  CHECK(parse_url("http://[::1]:80", "--agent").is_loopback());
  CHECK_FALSE(parse_url("http://127.0.0.1.evil.org", "--agent").is_loopback());
  CHECK(origin_of("http://HOST/x") == origin_of("http://host:80/y"));
  CHECK(origin_of("/relative") == "");
  for (const char* bad : {"http://", "file:///etc/passwd", "http://u@h/", "http://h/?k=v#f", "http://h/#f",
                          "http://h h/", "http://h/\xff"}) {
    CAPTURE(bad);
    CHECK(contains(message_of([&] { parse_url(bad, "--agent"); }, ExitCode::usage), "--agent: found"));
  }
  const auto ready = [](const char* url) { return readiness_addresses(parse_url(url, "--agent")); };
  CHECK(ready("http://h/proxy/v1?v=1") ==
        std::vector<std::string>{"http://h:80/proxy/v1/models?v=1", "http://h:80/proxy/health?v=1"});
  CHECK(ready("http://h/v2/models/m") ==
        std::vector<std::string>{"http://h:80/v2/models/m/ready", "http://h:80/v2/health/ready"});
}

TEST_CASE("remote: a query may hold a credential, or not") {
  std::istringstream lines(read_file("tests/data/addresses.txt"));
  int cases = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    CAPTURE(line);
    const std::string url = line.substr(line.find(' ') + 1);
    CHECK(may_hold_credential(url.substr(url.find('?') + 1)) == (line.rfind("refused", 0) == 0));
    ++cases;
  }
  CHECK(cases > 30);
}
