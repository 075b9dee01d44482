#include "remote/address.h"

#include <curl/curl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <new>

#include "base/error.h"
#include "base/words.h"

namespace physmas::remote {
namespace {

using UrlHandle = std::unique_ptr<CURLU, decltype(&curl_url_cleanup)>;

// Of a parameter's name, without what is no letter. The first anywhere in it, the second as the whole.
constexpr const char* kSecretParts[] = {"key",       "token", "secret", "passw", "pwd",     "credential",
                                        "signature", "auth",  "bearer", "jwt",   "session", "cookie"};
constexpr const char* kSecretNames[] = {"sig", "code", "sas", "pass", "pin", "otp"};
constexpr size_t kKeyLength = 20;  // characters without a break, letters and digits

std::string url_part(CURLU* url, CURLUPart part, unsigned flags = 0) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, flags) != CURLUE_OK) return "";
  std::string value(text);
  curl_free(text);
  return value;
}

std::string without_percent_signs(const std::string& text) {
  std::string plain;
  for (size_t i = 0; i < text.size(); ++i) {
    const auto is_digit = [&](size_t k) {
      return k < text.size() && std::isxdigit(static_cast<unsigned char>(text[k]));
    };
    if (text[i] == '%' && is_digit(i + 1) && is_digit(i + 2)) {
      plain += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

bool is_secret_name(const std::string& name) {
  std::string letters;
  for (const char c : lower_case(name)) {
    if (c >= 'a' && c <= 'z') letters += c;
  }
  return std::any_of(std::begin(kSecretParts), std::end(kSecretParts),
                     [&](const char* part) { return letters.find(part) != std::string::npos; }) ||
         std::find(std::begin(kSecretNames), std::end(kSecretNames), letters) != std::end(kSecretNames);
}

// As long without a break, and as mixed, as only keys are.
bool is_secret_value(const std::string& value) {
  size_t length = 0;
  bool letter = false, digit = false;
  for (const unsigned char c : value) {
    const bool is_letter = std::isalpha(c) != 0, is_digit = std::isdigit(c) != 0;
    if (!is_letter && !is_digit && c != '+' && c != '/' && c != '=' && c != '_') {
      length = 0;
      letter = digit = false;
      continue;
    }
    letter = letter || is_letter;
    digit = digit || is_digit;
    if (++length >= kKeyLength && letter && digit) return true;
  }
  return false;
}

}  // namespace

bool may_hold_credential(const std::string& query) {
  size_t from = 0;
  while (from <= query.size()) {
    const size_t end = std::min(query.find_first_of("&;", from), query.size());
    const std::string parameter = query.substr(from, end - from);
    const size_t equals = parameter.find('=');
    const std::string name = without_percent_signs(parameter.substr(0, equals));
    const std::string value = equals == std::string::npos ? "" : without_percent_signs(parameter.substr(equals + 1));
    if (is_secret_name(name) || is_secret_value(name) || is_secret_value(value)) return true;
    from = end + 1;
  }
  return false;
}

Url parse_url(const std::string& text, const std::string& flag) {
  const UrlHandle url(curl_url(), &curl_url_cleanup);
  const auto fail = [&](const std::string& found) {
    return Error(ExitCode::usage,
                 one_line(flag + ": found " + found + ", expected http[s]://host[:port][/path][?query]"));
  };
  if (url == nullptr) throw std::bad_alloc();
  const bool ascii = std::all_of(text.begin(), text.end(), [](unsigned char c) { return c > 0x20 && c < 0x7f; });
  if (!ascii || curl_url_set(url.get(), CURLUPART_URL, text.c_str(), CURLU_NON_SUPPORT_SCHEME) != CURLUE_OK)
    throw fail("a malformed URL");
  Url parsed;
  parsed.scheme = url_part(url.get(), CURLUPART_SCHEME);
  parsed.host = url_part(url.get(), CURLUPART_HOST);
  if (parsed.scheme != "http" && parsed.scheme != "https") throw fail("the scheme \"" + parsed.scheme + "\"");
  if (parsed.host.empty()) throw fail("a URL without a host");
  if (!url_part(url.get(), CURLUPART_USER).empty() || !url_part(url.get(), CURLUPART_PASSWORD).empty())
    throw fail("a user name in the URL of " + parsed.host + " (a key belongs into PM_API_KEY)");
  if (!url_part(url.get(), CURLUPART_FRAGMENT).empty()) throw fail("a fragment in the URL of " + parsed.host);
  const std::string query = url_part(url.get(), CURLUPART_QUERY);
  if (may_hold_credential(query))
    throw fail("what may be a credential in the query of the URL of " + parsed.host +
               " (a key belongs into PM_API_KEY, or into --headers FILE)");
  if (!query.empty()) parsed.query = "?" + query;
  parsed.origin = origin_of(text);
  parsed.path = url_part(url.get(), CURLUPART_PATH);
  while (!parsed.path.empty() && parsed.path.back() == '/') parsed.path.pop_back();
  return parsed;
}

std::string origin_of(const std::string& text) {
  const UrlHandle url(curl_url(), &curl_url_cleanup);
  if (url == nullptr || curl_url_set(url.get(), CURLUPART_URL, text.c_str(), 0) != CURLUE_OK) return "";
  return fmt::format("{}://{}:{}", url_part(url.get(), CURLUPART_SCHEME),
                     lower_case(url_part(url.get(), CURLUPART_HOST)),
                     url_part(url.get(), CURLUPART_PORT, CURLU_DEFAULT_PORT));
}

std::string path_of_server(const std::string& path) {
  const size_t models = path.rfind("/v2/models");
  if (models != std::string::npos) return path.substr(0, models);
  const std::string version = "/v1";
  const bool ends =
      path.size() >= version.size() && path.compare(path.size() - version.size(), version.size(), version) == 0;
  return ends ? path.substr(0, path.size() - version.size()) : path;
}

std::vector<std::string> readiness_addresses(const Url& endpoint) {
  const std::string server = endpoint.origin + path_of_server(endpoint.path), own = endpoint.origin + endpoint.path;
  const bool inference = endpoint.path.find("/v2/models") != std::string::npos;
  std::vector<std::string> addresses;
  for (const std::string& address :
       {own + (inference ? "/ready" : "/models"), server + (inference ? "/v2/health/ready" : "/health")})
    addresses.push_back(address + endpoint.query);
  return addresses;
}

}  // namespace physmas::remote
