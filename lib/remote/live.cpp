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
    : endpoint_(std::move(endpoint)), url_(parse_url(endpoint_, "endpoint")), key_(api_key()), options_(options) {
  secrets_.add(KeyMask(key_));
  masked_.add(KeyMask(key_));
  if (secrets_.is_in(endpoint_))
    throw Error(ExitCode::usage,
                "the URL of a server on " + url_.host + " holds PM_API_KEY, expected a URL without it");
  RequestHeaders more = load_request_headers(options_.headers);
  headers_ = std::move(more.headers);
  mask_headers(headers_);
  const bool unencrypted = url_.scheme == "http" && !url_.is_loopback();
  // A key goes under the name that the file of headers gives it, and under no other.
  if (more.holds_key) key_.clear();
  if (!key_.empty() && unencrypted) log_warning("PM_API_KEY travels unencrypted to " + url_.host);
  if (!headers_.empty() && unencrypted)
    log_warning("the headers of " + options_.headers + " travel unencrypted to " + url_.host);
}

void LiveBackend::mask_headers(const std::vector<Header>& headers) {
  for (const Header& header : headers) {
    const Secrecy secrecy = secrecy_of(header);
    if (secrecy == Secrecy::open) continue;
    // Of "Bearer KEY" the key alone is secret, too.
    std::vector<std::string> values = {header.value};
    if (const size_t blank = header.value.rfind(' '); blank != std::string::npos)
      values.push_back(header.value.substr(blank + 1));
    for (const std::string& value : values) {
      const KeyMask mask(value, "[header]");
      masked_.add(mask);
      if (secrecy != Secrecy::secret) continue;
      secrets_.add(mask);
      if (mask.is_in(endpoint_)) {
        throw Error(ExitCode::usage, "the URL of a server on " + url_.host + " holds the value of the header " +
                                         header.name + ", expected a URL without it");
      }
    }
  }
}

void LiveBackend::wait(double seconds, const std::string& why) {
  if (seconds >= left()) {
    throw provider_error(
        endpoint_, fmt::format("{}; waiting {:g} s would exceed the budget of {:g} s", why, seconds, options_.budget));
  }
  log_info(fmt::format("{}: {}; trying again in {:g} s", endpoint_, why, seconds));
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

double LiveBackend::backoff(int waits) const {
  return std::min(kLongestBackoff, options_.backoff * std::exp2(waits));
}

std::string LiveBackend::said_by(const HttpResult& result) const {
  return words_of(masked_.masked(result.body));
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
                                       result.status, target.empty() ? "nowhere" : masked_.masked(target)));
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

HttpRequest LiveBackend::http_request(const Request& request) const {
  HttpRequest http;
  http.method = request.method;
  http.url = url_.origin + url_.path + request.path + url_.query;
  RequestBytes bytes = request_bytes(request);
  http.body = std::move(bytes.bytes);
  http.json_length = bytes.json_length;
  http.bearer = key_;
  http.headers = headers_;
  http.reply_limit = request.reply_limit;
  return http;
}

int LiveBackend::probe(const std::string& address, size_t reply_limit, Json& attempts) {
  HttpRequest request;
  request.method = "GET";
  request.url = address;
  request.bearer = key_;
  request.headers = headers_;
  request.reply_limit = reply_limit;
  const int status = follow_redirects(request).status;
  attempts.push_back({{"probe", address.substr(url_.origin.size())}, {"status", status}});
  return status;
}

// Whether a refusal says that the server is not ready yet. Triton answers 400 where a model is not ready, but also
// where there is none: then the server itself is ready.
bool LiveBackend::is_loading(const Request& request, const HttpResult& result, Json& attempts) {
  if (result.outcome != Outcome::answered) return false;
  if (result.status == 503) return true;
  return result.status == 400 && !request.wants_json &&
         !is_success(probe(readiness_addresses(url_).back(), request.reply_limit, attempts));
}

// Waits, longer each time, until the server says that it is ready, or says nothing of that sort. Whether it was not
// ready: then the refusal does not count as one.
bool LiveBackend::waits_until_ready(const Request& request, const HttpResult& refusal, int& waits, Json& attempts) {
  const std::string words = said_by(refusal);
  const std::string why = fmt::format("HTTP {}", refusal.status) + (words.empty() ? "" : ": " + words);
  if (!told_of_waiting_) {
    log_note(fmt::format("{}: {}; waiting for it, {:.0f} s at most (--budget)", endpoint_, why, left()));
    told_of_waiting_ = true;
  }
  for (bool was_ready = true;; was_ready = false) {
    wait(std::max(refusal.retry_after, backoff(waits++)), why);
    // A request that asks whether the server is ready is its own probe.
    if (!request.wants_json) return true;
    bool not_ready = false;
    for (const std::string& address : readiness_addresses(url_)) {
      const int status = probe(address, request.reply_limit, attempts);
      if (is_success(status)) return !was_ready;
      not_ready = not_ready || status == 503;
    }
    if (!not_ready) return true;
  }
}

HttpResult LiveBackend::answered(const Request& request, Json& attempts) {
  const HttpRequest http = http_request(request);
  int waits = 0;
  for (int attempt = 0;; ++attempt) {
    const Stopwatch watch;
    HttpResult result = follow_redirects(http);
    attempts.push_back({{"status", result.status}, {"why", masked_.masked(result.why)}, {"seconds", watch.seconds()}});
    const bool loading = is_loading(request, result, attempts);
    if (!loading && !is_worth_retrying(result)) return result;
    if (loading && waits_until_ready(request, result, waits, attempts)) {
      --attempt;
      continue;
    }
    const bool broken = result.outcome == Outcome::broken;
    const std::string why = broken ? masked_.masked(result.why) : fmt::format("HTTP {}", result.status);
    const std::string words = broken ? "" : said_by(result);
    const std::string reason = words.empty() ? "" : ": " + words;
    if (attempt == options_.retries) {
      throw provider_error(endpoint_,
                           fmt::format("{} after {} attempt{}{}", why, attempt + 1, attempt == 0 ? "" : "s", reason));
    }
    // For a server that is loading the wait is over.
    if (!loading) wait(std::max(result.retry_after, backoff(attempt)), why + reason);
  }
}

void LiveBackend::check(const Request& request, const HttpResult& result) const {
  const std::string size = fmt::format("{} bytes", request.reply_limit);
  switch (result.outcome) {
    case Outcome::answered:
      break;
    case Outcome::timed_out:
      throw provider_error(endpoint_,
                           fmt::format("no complete reply within {:g} s; --timeout (TIMEOUT=) gives it longer",
                                       std::min(options_.timeout, options_.budget)));
    case Outcome::too_large:
      throw provider_error(endpoint_, "found a longer reply, expected at most " + size);
    default:
      throw provider_error(endpoint_, masked_.masked(result.why));
  }
  const auto& returned = request.returned_statuses;
  if (!is_success(result.status)) {
    if (std::find(returned.begin(), returned.end(), result.status) != returned.end()) return;
    const char* fix = result.status == 401 || result.status == 403 ? "; is PM_API_KEY set to a valid key?" : "";
    const std::string words = said_by(result);
    throw provider_error(endpoint_, fmt::format("HTTP {}{}{}", result.status, words.empty() ? "" : ": " + words, fix));
  }
  if (secrets_.is_in(result.body))
    throw provider_error(endpoint_, "the reply repeats the key or a header; it is not used and not kept");
  if (!request.wants_json) return;
  const std::string& type = result.content_type;
  const bool json = type == "application/json" || (type.rfind("application/", 0) == 0 && type.size() > 5 &&
                                                   type.compare(type.size() - 5, 5, "+json") == 0);
  if (result.json_length > result.body.size()) {
    throw provider_error(endpoint_, fmt::format("found {} bytes, expected at least {} of JSON, as its header says",
                                                result.body.size(), result.json_length));
  }
  if (!json && result.json_length == 0) {
    throw provider_error(endpoint_, fmt::format("found a reply of type \"{}\", expected application/json",
                                                one_line(masked_.masked(type), 80)));
  }
}

Reply LiveBackend::exchange(const Request& request) {
  const Stopwatch watch;
  ExchangeRecord record;
  record.runtime["attempts"] = Json::array();
  HttpResult result = answered(request, record.runtime["attempts"]);
  check(request, result);
  const bool success = is_success(result.status);
  if (success && result.json_length > 0) {
    record.binary = result.body.substr(result.json_length);
    result.body.resize(result.json_length);
  }
  // What is kept is what is used, so that a replay gives the same.
  result.body = masked_.masked(text_or_nothing(result.body));
  record.name = request.name;
  record.method = request.method;
  record.url = url_.origin + url_.path + request.path + url_.query;
  record.request_body = recorded_body(request);
  for (const Attachment& a : request.attachments) record.attachments.push_back(attachment_file(a));
  for (const Header& header : headers_) record.headers.push_back(header.name);
  record.added = request.added;
  record.manner = request.manner;
  record.status = result.status;
  record.content_type = masked_.masked(text_or_nothing(result.content_type));
  record.body = result.body;
  Reply reply;
  reply.status = result.status;
  if (success && request.wants_json) {
    try {
      reply.body = parse_reply(result.body, endpoint_, request.loose_numbers);
    } catch (const Error& e) {
      throw Error(e.code(), masked_.masked(e.what()));
    }
    // Escapes in the JSON may have hidden it from the look at the raw body.
    if (secrets_.is_in(reply.body.dump()))
      throw provider_error(endpoint_, "the reply repeats the key or a header; it is not used and not kept");
  }
  if (success) reply.binary = record.binary;
  if (!success) reply.said = record.body;
  record.runtime["seconds"] = watch.seconds();
  if (!options_.exchanges.empty()) save_exchange(options_.exchanges, record, request);
  exchanges_.push_back({record.name, record.sha256()});
  return reply;
}

}  // namespace physmas::remote
