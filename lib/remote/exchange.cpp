#include "remote/exchange.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "records/json.h"
#include "remote/base64.h"

namespace physmas::remote {
namespace {

constexpr size_t kMaxRecordBytes = size_t{256} << 20;

std::string shown(const Json& value) {
  return one_line(compact_text(value), 120);
}

// Fields that earlier versions did not have are there only where they say something: records keep their hashes.
Json request_json(const ExchangeRecord& record) {
  Json json = {{"method", record.method},
               {"url", record.url},
               {"body", record.request_body},
               {"attachments", record.attachments}};
  if (!record.headers.empty()) {
    json["headers"] = Json::object();
    for (const std::string& name : record.headers) json["headers"][name] = "[masked]";
  }
  if (!record.added.empty()) json["added"] = record.added;
  if (!record.manner.is_null()) json["manner"] = record.manner;
  return json;
}

std::string binary_file(const ExchangeRecord& record) {
  return sha256_text(record.binary) + ".bin";
}

Json response_json(const ExchangeRecord& record) {
  Json json = {{"status", record.status},
               {"content_type", record.content_type},
               {"sha256", sha256_text(record.body)},
               {"body", record.body}};
  if (!record.binary.empty()) json["binary"] = binary_file(record);
  return json;
}

// Bare NaN, Infinity and -Infinity, as some servers write them, are null outside strings.
std::string without_loose_numbers(const std::string& text) {
  std::string strict;
  strict.reserve(text.size());
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      strict += c;
      if (c == '\\' && i + 1 < text.size()) strict += text[++i];
      if (c == '"') quoted = false;
      continue;
    }
    size_t length = 0;
    for (const char* word : {"NaN", "-NaN", "Infinity", "-Infinity"}) {
      if (text.compare(i, std::char_traits<char>::length(word), word) == 0)
        length = std::char_traits<char>::length(word);
    }
    if (length > 0) {
      strict += "null";
      i += length - 1;
      continue;
    }
    quoted = c == '"';
    strict += c;
  }
  return strict;
}

}  // namespace

Json recorded_body(const Request& request) {
  Json body = request.body;
  for (const Attachment& a : request.attachments)
    body[Json::json_pointer(a.pointer)] = "sha256:" + sha256_text(a.bytes);
  return body;
}

Json sent_body(const Request& request) {
  Json body = request.body;
  for (const Attachment& a : request.attachments) body[Json::json_pointer(a.pointer)] = a.prefix + base64_of(a.bytes);
  return body;
}

RequestBytes request_bytes(const Request& request) {
  if (request.method != "POST") return {};
  Json body = sent_body(request);
  for (const BinaryPart& part : request.parts) {
    const Json::json_pointer data(part.pointer);
    body[data.parent_pointer()].erase(data.back());
  }
  RequestBytes bytes{body.dump(), 0};
  if (!request.parts.empty()) bytes.json_length = bytes.bytes.size();
  for (const BinaryPart& part : request.parts) bytes.bytes += part.bytes;
  return bytes;
}

std::string attachment_file(const Attachment& attachment) {
  return sha256_text(attachment.bytes) + "." + attachment.extension;
}

std::string ExchangeRecord::sha256() const {
  const Json both = {{"request", request_json(*this)}, {"response", response_json(*this)}};
  return sha256_text(both.dump());
}

void save_exchange(const std::string& folder, const ExchangeRecord& record, const Request& request) {
  for (const Attachment& a : request.attachments) write_file(join_path(folder, attachment_file(a)), a.bytes);
  if (!record.binary.empty()) write_file(join_path(folder, binary_file(record)), record.binary);
  Json json;
  json["name"] = record.name;
  json["sha256"] = record.sha256();
  json["request"] = request_json(record);
  json["response"] = response_json(record);
  json["runtime"] = record.runtime;
  Provenance provenance;
  provenance.tool = tool_name();
  save_record(join_path(folder, record.name + ".json"), "exchange", provenance, json);
}

ExchangeRecord load_exchange(const std::string& path) {
  Json document = parse_json(read_file(path, kMaxRecordBytes), path);
  validate_record(document, "exchange", path);
  ExchangeRecord record;
  record.name = document.at("name").get<std::string>();
  const Json& request = document.at("request");
  record.method = request.at("method").get<std::string>();
  record.url = request.at("url").get<std::string>();
  record.request_body = request.at("body");
  record.attachments = request.at("attachments").get<std::vector<std::string>>();
  if (request.contains("headers")) {
    for (const auto& [header, value] : request.at("headers").items()) record.headers.push_back(header);
  }
  if (request.contains("added")) record.added = request.at("added").get<std::vector<std::string>>();
  if (request.contains("manner")) record.manner = request.at("manner");
  const Json& response = document.at("response");
  record.status = response.at("status").get<int>();
  record.content_type = response.at("content_type").get<std::string>();
  record.body = response.at("body").get<std::string>();
  if (response.at("sha256") != sha256_text(record.body)) {
    throw invalid_field(path, "/response/sha256", response.at("sha256"),
                        sha256_text(record.body) + ", that of the body", "the reply was changed after it was recorded");
  }
  if (response.contains("binary")) {
    const std::string name = response.at("binary").get<std::string>();
    record.binary = read_file(join_path(folder_of(path), name), kMaxRecordBytes);
    if (binary_file(record) != name)
      throw invalid_input({join_path(folder_of(path), name), "", "other bytes than its name says", "those of the reply",
                           "the reply was changed after it was recorded"});
  }
  if (document.at("sha256") != record.sha256()) {
    throw invalid_field(path, "/sha256", document.at("sha256"), record.sha256() + ", that of request and response",
                        "the exchange was changed after it was recorded");
  }
  return record;
}

std::optional<Difference> first_difference(const Json& now, const Json& recorded, const std::string& pointer) {
  if (now.is_null() || now == recorded) return std::nullopt;
  if (now.is_object() && recorded.is_object()) {
    for (const auto& [key, value] : now.items()) {
      if (value.is_null()) continue;
      if (!recorded.contains(key)) return Difference{pointer + "/" + key, shown(value), "nothing"};
      if (auto found = first_difference(value, recorded.at(key), pointer + "/" + key)) return found;
    }
    for (const auto& [key, value] : recorded.items()) {
      if (!now.contains(key)) return Difference{pointer + "/" + key, "nothing", shown(value)};
    }
    return std::nullopt;
  }
  if (now.is_array() && recorded.is_array() && now.size() == recorded.size()) {
    for (size_t i = 0; i < now.size(); ++i) {
      if (auto found = first_difference(now[i], recorded[i], pointer + "/" + std::to_string(i))) return found;
    }
    return std::nullopt;
  }
  if (now.is_array() && recorded.is_array())
    return Difference{pointer, fmt::format("{} entries", now.size()), fmt::format("{} entries", recorded.size())};
  if (now.is_string() && recorded.is_string()) {
    // Long texts: show where they part.
    const std::string &a = now.get_ref<const std::string&>(), &b = recorded.get_ref<const std::string&>();
    const size_t common =
        std::mismatch(a.begin(), a.begin() + std::min(a.size(), b.size()), b.begin()).first - a.begin();
    const size_t from = common > 20 ? common - 20 : 0;
    const auto around = [&](const std::string& s) { return (from > 0 ? "..." : "") + shown(Json(s.substr(from, 60))); };
    return Difference{pointer, around(a), around(b)};
  }
  return Difference{pointer, shown(now), shown(recorded)};
}

std::optional<Difference> difference_from(const ExchangeRecord& record, const Request& request) {
  Json now = recorded_body(request), recorded = record.request_body;
  if (request.added.empty() && now.is_object() && recorded.is_object()) {
    for (const std::string& field : record.added) {
      now.erase(field);
      recorded.erase(field);
    }
  }
  return first_difference(now, recorded, "/request/body");
}

Json parse_reply(const std::string& body, const std::string& source, bool loose_numbers) {
  try {
    return parse_json(loose_numbers ? without_loose_numbers(body) : body, source);
  } catch (const Error& e) {
    throw Error(ExitCode::provider_failed, e.what());
  }
}

std::string words_of(const std::string& body) {
  constexpr size_t kLimit = 320, kBeginning = 100;
  std::string text = body;
  try {
    Json json = parse_json(body, "error");
    // {"error": {"message": ...}}, {"error": ...}, {"message": ...}, {"detail": ...}: as servers have them.
    for (const char* field : {"error", "message", "detail"}) {
      if (json.is_object() && json.contains(field) && !json.at(field).is_null()) {
        const Json inner = json.at(field);
        json = inner;
      }
    }
    text = json.is_string() ? json.get<std::string>() : json.dump();
    if (json.is_object() && json.empty()) text.clear();
  } catch (const Error&) {
    // No JSON: a page of a proxy, say. A reader wants its text.
    std::string plain;
    bool tag = false;
    for (const char c : body) {
      if (c == '<') tag = true;
      if (!tag) plain += c;
      if (c == '>') {
        tag = false;
        plain += ' ';
      }
    }
    text = plain;
  }
  // Runs of blanks, as pages have them, say nothing.
  std::string shown;
  for (const char c : one_line(text, 16384)) {
    if (c != ' ' || (!shown.empty() && shown.back() != ' ')) shown += c;
  }
  while (!shown.empty() && shown.back() == ' ') shown.pop_back();
  if (shown.size() <= kLimit) return shown;
  // A traceback says last what went wrong.
  return one_line(shown, kBeginning) + " " + one_line(shown.substr(shown.size() - (kLimit - kBeginning)), kLimit);
}

Error provider_error(const std::string& source, const std::string& what) {
  return Error(ExitCode::provider_failed, one_line(source + ": " + what, 1000));
}

}  // namespace physmas::remote
