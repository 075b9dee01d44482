#include "remote/live.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "base/log.h"
#include "records/json.h"

namespace physmas::remote {
namespace {

using Outcome = HttpResult::Outcome;

constexpr double kLongestBackoff = 30;  // s
constexpr int kMaxRedirects = 3;

bool is_success(int status) {
  return status >= 200 && status < 300;
}

bool is_redirect(int status) {
  return status >= 300 && status < 400 && status != 304;
}

bool is_worth_retrying(const HttpResult& result) {
  if (result.outcome == Outcome::broken) return true;
  // A request that timed out is not sent again: the model may still be working on it.
  return result.outcome == Outcome::answered &&
         (result.status == 408 || result.status == 429 || (result.status >= 500 && result.status != 501));
}

std::string api_key() {
  const char* text = std::getenv("PM_API_KEY");
  const std::string key = text == nullptr ? "" : text;
  if (std::any_of(key.begin(), key.end(), [](unsigned char c) { return c <= 0x20 || c >= 0x7f; })) {
    throw Error(ExitCode::usage,
                "PM_API_KEY: found a character that no key has, expected visible ASCII without spaces");
  }
  return key;
}

// Error pages and headers may hold anything; records are UTF-8.
std::string text_or_nothing(const std::string& text) {
  try {
    Json(text).dump();
    return text;
  } catch (const Json::exception&) {
    return "";
  }
}

}  // namespace

LiveBackend::LiveBackend(std::string endpoint, const RemoteOptions& options)
    : endpoint_(std::move(endpoint)), key_(api_key()), options_(options) {
  const Url url = parse_url(endpoint_, "endpoint");
  if (!key_.empty() && url.scheme == "http" && !url.is_loopback())
    log_warning("PM_API_KEY travels unencrypted to " + url.host);
}

std::string LiveBackend::without_key(const std::string& text) const {
  if (key_.empty()) return text;
  const std::string shown = "[key]";
  std::string clean = text;
  // The key may be a part of what stands for it.
  for (size_t at = clean.find(key_); at != std::string::npos; at = clean.find(key_, at + shown.size()))
    clean.replace(at, key_.size(), shown);
  return clean;
}

void LiveBackend::wait(double seconds, const std::string& why) {
  if (seconds >= left()) {
    throw provider_error(endpoint_, fmt::format("{}; waiting {:g} s would exceed the budget of {:g} s",
                                                without_key(why), seconds, options_.budget));
  }
  log_info(fmt::format("{}: {}; trying again in {:g} s", endpoint_, without_key(why), seconds));
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

HttpResult LiveBackend::follow_redirects(HttpRequest request) {
  for (int hop = 0;; ++hop) {
    request.timeout = std::min(options_.timeout, left());
    if (request.timeout <= 0)
      throw provider_error(endpoint_, fmt::format("the budget of {:g} s is spent", options_.budget));
    HttpResult result = http_.send(request);
    if (result.outcome != Outcome::answered || !is_redirect(result.status)) return result;
    const std::string target = origin_of(result.location);
    if (target != origin_of(request.url)) {
      throw provider_error(endpoint_,
                           fmt::format("HTTP {}: a redirect to {} is refused, expected an answer from this host",
                                       result.status, target.empty() ? "nowhere" : without_key(target)));
    }
    // Only 307 and 308 keep method and body.
    if ((result.status != 307 && result.status != 308) || hop == kMaxRedirects) {
      throw provider_error(endpoint_, fmt::format("HTTP {}: found {}, expected an answer", result.status,
                                                  hop == kMaxRedirects ? "one redirect after another"
                                                                       : "a redirect that drops the request"));
    }
    request.url = result.location;
  }
}

HttpResult LiveBackend::answered(const Request& request, const std::string& body, Json& attempts) {
  HttpRequest http;
  http.method = request.method;
  http.url = endpoint_ + request.path;
  http.body = body;
  http.bearer = key_;
  http.reply_limit = request.reply_limit;
  for (int attempt = 0;; ++attempt) {
    const Stopwatch watch;
    HttpResult result = follow_redirects(http);
    attempts.push_back({{"status", result.status}, {"why", without_key(result.why)}, {"seconds", watch.seconds()}});
    if (!is_worth_retrying(result)) return result;
    const std::string why = result.outcome == Outcome::broken ? result.why : fmt::format("HTTP {}", result.status);
    if (attempt == options_.retries) {
      throw provider_error(
          endpoint_, fmt::format("{} after {} attempt{}", without_key(why), attempt + 1, attempt == 0 ? "" : "s"));
    }
    wait(std::max(result.retry_after, std::min(kLongestBackoff, options_.backoff * std::exp2(attempt))), why);
  }
}

void LiveBackend::check(const Request& request, const HttpResult& result) const {
  const std::string size = fmt::format("{} bytes", request.reply_limit);
  switch (result.outcome) {
    case Outcome::answered:
      break;
    case Outcome::timed_out:
      throw provider_error(endpoint_,
                           fmt::format("no complete reply within {:g} s", std::min(options_.timeout, options_.budget)));
    case Outcome::too_large:
      throw provider_error(endpoint_, "found a longer reply, expected at most " + size);
    default:
      throw provider_error(endpoint_, without_key(result.why));
  }
  const auto& returned = request.returned_statuses;
  if (!is_success(result.status)) {
    if (std::find(returned.begin(), returned.end(), result.status) != returned.end()) return;
    const char* fix = result.status == 401 || result.status == 403 ? "; is PM_API_KEY set to a valid key?" : "";
    throw provider_error(endpoint_,
                         fmt::format("HTTP {}: {}{}", result.status, one_line(without_key(result.body), 200), fix));
  }
  if (!key_.empty() && result.body.find(key_) != std::string::npos)
    throw provider_error(endpoint_, "the reply repeats the key; it is not used and not kept");
  if (!request.wants_json) return;
  const std::string& type = result.content_type;
  const bool json = type == "application/json" || (type.rfind("application/", 0) == 0 && type.size() > 5 &&
                                                   type.compare(type.size() - 5, 5, "+json") == 0);
  if (!json) {
    throw provider_error(endpoint_, fmt::format("found a reply of type \"{}\", expected application/json",
                                                one_line(without_key(type), 80)));
  }
}

Reply LiveBackend::exchange(const Request& request) {
  const Stopwatch watch;
  ExchangeRecord record;
  record.runtime["attempts"] = Json::array();
  const std::string body = request.method == "POST" ? sent_body(request).dump() : "";
  const HttpResult result = answered(request, body, record.runtime["attempts"]);
  check(request, result);
  Reply reply;
  reply.status = result.status;
  if (is_success(result.status) && request.wants_json) {
    try {
      reply.body = parse_reply(result.body, endpoint_);
    } catch (const Error& e) {
      throw Error(e.code(), without_key(e.what()));
    }
    // Escapes in the JSON may have hidden it from the look at the raw body.
    if (!key_.empty() && reply.body.dump().find(key_) != std::string::npos)
      throw provider_error(endpoint_, "the reply repeats the key; it is not used and not kept");
  }
  record.name = request.name;
  record.method = request.method;
  record.url = endpoint_ + request.path;
  record.request_body = recorded_body(request);
  for (const Attachment& a : request.attachments) record.attachments.push_back(attachment_file(a));
  record.status = result.status;
  record.content_type = without_key(text_or_nothing(result.content_type));
  record.body = without_key(text_or_nothing(result.body));
  record.runtime["seconds"] = watch.seconds();
  save_exchange(options_.exchanges, record, request);
  exchanges_.push_back({record.name, record.sha256()});
  return reply;
}

}  // namespace physmas::remote
