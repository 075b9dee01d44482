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
  if (key_.is_in(endpoint_))
    throw Error(ExitCode::usage, "the URL of a server on " + url.host + " holds PM_API_KEY, expected a URL without it");
  if (!key_.key().empty() && url.scheme == "http" && !url.is_loopback())
    log_warning("PM_API_KEY travels unencrypted to " + url.host);
}

void LiveBackend::wait(double seconds, const std::string& why) {
  if (seconds >= left()) {
    throw provider_error(endpoint_, fmt::format("{}; waiting {:g} s would exceed the budget of {:g} s",
                                                key_.masked(why), seconds, options_.budget));
  }
  log_info(fmt::format("{}: {}; trying again in {:g} s", endpoint_, key_.masked(why), seconds));
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
                                       result.status, target.empty() ? "nowhere" : key_.masked(target)));
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
  http.bearer = key_.key();
  http.reply_limit = request.reply_limit;
  for (int attempt = 0;; ++attempt) {
    const Stopwatch watch;
    HttpResult result = follow_redirects(http);
    attempts.push_back({{"status", result.status}, {"why", key_.masked(result.why)}, {"seconds", watch.seconds()}});
    if (!is_worth_retrying(result)) return result;
    const std::string why = result.outcome == Outcome::broken ? result.why : fmt::format("HTTP {}", result.status);
    if (attempt == options_.retries) {
      throw provider_error(
          endpoint_, fmt::format("{} after {} attempt{}", key_.masked(why), attempt + 1, attempt == 0 ? "" : "s"));
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
      throw provider_error(endpoint_, key_.masked(result.why));
  }
  const auto& returned = request.returned_statuses;
  if (!is_success(result.status)) {
    if (std::find(returned.begin(), returned.end(), result.status) != returned.end()) return;
    const char* fix = result.status == 401 || result.status == 403 ? "; is PM_API_KEY set to a valid key?" : "";
    throw provider_error(endpoint_,
                         fmt::format("HTTP {}: {}{}", result.status, one_line(key_.masked(result.body), 200), fix));
  }
  if (key_.is_in(result.body))
    throw provider_error(endpoint_, "the reply repeats the key; it is not used and not kept");
  if (!request.wants_json) return;
  const std::string& type = result.content_type;
  const bool json = type == "application/json" || (type.rfind("application/", 0) == 0 && type.size() > 5 &&
                                                   type.compare(type.size() - 5, 5, "+json") == 0);
  if (!json) {
    throw provider_error(endpoint_, fmt::format("found a reply of type \"{}\", expected application/json",
                                                one_line(key_.masked(type), 80)));
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
      throw Error(e.code(), key_.masked(e.what()));
    }
    // Escapes in the JSON may have hidden it from the look at the raw body.
    if (key_.is_in(reply.body.dump()))
      throw provider_error(endpoint_, "the reply repeats the key; it is not used and not kept");
  }
  record.name = request.name;
  record.method = request.method;
  record.url = endpoint_ + request.path;
  record.request_body = recorded_body(request);
  for (const Attachment& a : request.attachments) record.attachments.push_back(attachment_file(a));
  record.status = result.status;
  record.content_type = key_.masked(text_or_nothing(result.content_type));
  record.body = key_.masked(text_or_nothing(result.body));
  record.runtime["seconds"] = watch.seconds();
  save_exchange(options_.exchanges, record, request);
  exchanges_.push_back({record.name, record.sha256()});
  return reply;
}

}  // namespace physmas::remote
