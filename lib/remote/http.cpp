#include "remote/http.h"

#include <curl/curl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <mutex>

#include "base/error.h"
#include "base/words.h"

namespace physmas::remote {
namespace {

// Of the binary tensor extension: how much of a body is JSON.
constexpr const char* kJsonLength = "Inference-Header-Content-Length";

using Headers = std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)>;

struct Sink {
  std::string body;
  size_t limit = 0;
  bool overflow = false;
};

size_t receive(char* data, size_t size, size_t count, void* sink) {
  Sink& s = *static_cast<Sink*>(sink);
  if (s.body.size() + size * count > s.limit) {
    s.overflow = true;
    return 0;
  }
  s.body.append(data, size * count);
  return size * count;
}

Headers add_header(Headers list, const std::string& line) {
  curl_slist* grown = curl_slist_append(list.get(), line.c_str());
  if (grown == nullptr) throw std::bad_alloc();
  list.release();
  return Headers(grown, &curl_slist_free_all);
}

// "Application/JSON; charset=utf-8" -> "application/json".
std::string plain_type(const char* header) {
  std::string type = header == nullptr ? "" : header;
  type = type.substr(0, type.find(';'));
  while (!type.empty() && std::isspace(static_cast<unsigned char>(type.back()))) type.pop_back();
  return lower_case(type);
}

HttpResult::Outcome outcome_of(CURLcode code, bool overflow) {
  if (overflow || code == CURLE_FILESIZE_EXCEEDED) return HttpResult::Outcome::too_large;
  switch (code) {
    case CURLE_OK:
      return HttpResult::Outcome::answered;
    case CURLE_OPERATION_TIMEDOUT:
      return HttpResult::Outcome::timed_out;
    case CURLE_COULDNT_CONNECT:
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_PARTIAL_FILE:
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM:
      return HttpResult::Outcome::broken;
    default:
      return HttpResult::Outcome::refused;
  }
}

}  // namespace

struct HttpClient::Handle {
  CURL* easy = nullptr;
};

HttpClient::HttpClient() : handle_(std::make_unique<Handle>()) {
  static std::once_flag once;
  std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
  handle_->easy = curl_easy_init();
  if (handle_->easy == nullptr) throw internal_error("libcurl cannot be set up");
}

HttpClient::~HttpClient() {
  curl_easy_cleanup(handle_->easy);
}

HttpResult HttpClient::send(const HttpRequest& request) {
  CURL* curl = handle_->easy;
  curl_easy_reset(curl);
  Sink sink;
  sink.limit = request.reply_limit;
  Headers headers(nullptr, &curl_slist_free_all);
  headers = add_header(std::move(headers), "Accept: application/json");
  // Without this libcurl waits a second for "100 Continue" from servers that never send it.
  headers = add_header(std::move(headers), "Expect:");
  if (request.method == "POST") {
    headers = add_header(std::move(headers), request.json_length == 0 ? "Content-Type: application/json"
                                                                      : "Content-Type: application/octet-stream");
  }
  if (request.json_length != 0)
    headers = add_header(std::move(headers), fmt::format("{}: {}", kJsonLength, request.json_length));
  bool authorised = false;
  for (const Header& header : request.headers) {
    headers = add_header(std::move(headers), header.name + ": " + header.value);
    authorised = authorised || lower_case(header.name) == "authorization";
  }
  if (!request.bearer.empty() && !authorised)
    headers = add_header(std::move(headers), "Authorization: Bearer " + request.bearer);
  curl_easy_setopt(curl, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl, CURLOPT_NETRC, static_cast<long>(CURL_NETRC_IGNORED));
  curl_easy_setopt(curl, CURLOPT_USERAGENT, "physmas/" PHYSMAS_VERSION);
  curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers.get());
  const long milliseconds = std::max(1L, static_cast<long>(request.timeout * 1000));
  curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, milliseconds);
  curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT_MS, std::min(milliseconds, 10000L));
  // Refuses by Content-Length; the sink refuses what has none.
  curl_easy_setopt(curl, CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(request.reply_limit));
  curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, receive);
  curl_easy_setopt(curl, CURLOPT_WRITEDATA, &sink);
  if (request.method == "POST") {
    curl_easy_setopt(curl, CURLOPT_POST, 1L);
    curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(request.body.size()));
    curl_easy_setopt(curl, CURLOPT_POSTFIELDS, request.body.data());
  }
  const CURLcode code = curl_easy_perform(curl);

  HttpResult result;
  result.outcome = outcome_of(code, sink.overflow);
  if (code != CURLE_OK) result.why = curl_easy_strerror(code);
  long status = 0;
  curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
  result.status = static_cast<int>(status);
  const char* text = nullptr;
  curl_easy_getinfo(curl, CURLINFO_CONTENT_TYPE, &text);
  result.content_type = plain_type(text);
  text = nullptr;
  curl_easy_getinfo(curl, CURLINFO_REDIRECT_URL, &text);
  if (text != nullptr) result.location = text;
  curl_off_t wait = 0;
  curl_easy_getinfo(curl, CURLINFO_RETRY_AFTER, &wait);
  result.retry_after = static_cast<double>(wait);
  curl_header* header = nullptr;
  if (curl_easy_header(curl, kJsonLength, 0, CURLH_HEADER, -1, &header) == CURLHE_OK) {
    const std::string length = header->value;
    // Anything else is no number, and the body no JSON either.
    if (!length.empty() && length.size() < 12 &&
        std::all_of(length.begin(), length.end(), [](char c) { return c >= '0' && c <= '9'; }))
      result.json_length = std::stoull(length);
  }
  result.body = std::move(sink.body);
  return result;
}

}  // namespace physmas::remote
