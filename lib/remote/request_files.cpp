#include "remote/request_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "records/json.h"
#include "remote/address.h"

namespace physmas::remote {
namespace {

constexpr size_t kShortestMasked = 6;
constexpr size_t kMaxHeaderBytes = 64 << 10, kMaxBodyBytes = 1 << 20;

// What the client itself says of the bytes it sends.
const std::set<std::string> kOwnHeaders = {"connection",     "content-encoding",
                                           "content-length", "content-type",
                                           "expect",         "inference-header-content-length",
                                           "keep-alive",     "te",
                                           "trailer",        "transfer-encoding",
                                           "upgrade"};
const std::set<std::string> kOpenHeaders = {"host", "accept", "user-agent"};
const std::set<std::string> kOwnFields = {"model", "messages", "response_format", "stream", "n"};

std::string trimmed(const std::string& text) {
  const size_t from = text.find_first_not_of(" \t");
  return from == std::string::npos ? "" : text.substr(from, text.find_last_not_of(" \t") - from + 1);
}

bool is_name(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string("!#$%&'*+-.^_`|~").find(static_cast<char>(c)) != std::string::npos;
  });
}

}  // namespace

Secrecy secrecy_of(const Header& header) {
  if (kOpenHeaders.count(lower_case(header.name)) != 0) return Secrecy::open;
  // A header is a credential as a parameter of a query is.
  if (may_hold_credential(header.name + "=") || may_hold_credential("v=" + header.value)) return Secrecy::secret;
  return header.value.size() < kShortestMasked ? Secrecy::open : Secrecy::masked;
}

RequestHeaders load_request_headers(const std::string& path) {
  RequestHeaders found;
  if (path.empty()) return found;
  std::istringstream lines(read_file(path, kMaxHeaderBytes));
  std::string line;
  std::set<std::string> seen;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (trimmed(line).empty() || line[0] == '#') continue;
    const auto bad = [&](const std::string& what, const std::string& expected) {
      return invalid_input({path, fmt::format("line {}", number), what, expected});
    };
    const size_t colon = line.find(':');
    const std::string name = line.substr(0, colon);
    if (colon == std::string::npos || !is_name(name)) throw bad("no header", "Name: value");
    if (kOwnHeaders.count(lower_case(name)) != 0) throw bad("the header " + name, "another: the protocol sets it");
    if (!seen.insert(lower_case(name)).second) throw bad("the header " + name + " again", "every header once");
    std::string value = trimmed(line.substr(colon + 1)), filled;
    for (size_t from = 0;;) {
      const size_t at = value.find("${", from);
      const size_t end = at == std::string::npos ? at : value.find('}', at);
      filled += value.substr(from, at == std::string::npos ? at : at - from);
      if (at == std::string::npos) break;
      const std::string variable = end == std::string::npos ? "" : value.substr(at + 2, end - at - 2);
      const char* text = variable.empty() ? nullptr : std::getenv(variable.c_str());
      // What stands between the braces may be the secret itself, put there by mistake.
      if (text == nullptr || *text == 0)
        throw bad("a variable of the environment in the header " + name + " that is not set", "${NAME} of one that is");
      filled += text;
      found.holds_key = found.holds_key || variable == "PM_API_KEY";
      from = end + 1;
    }
    if (filled.empty()) throw bad("the header " + name + " without a value", "Name: value");
    if (std::any_of(filled.begin(), filled.end(), [](unsigned char c) { return c < 0x20 || c >= 0x7f; }))
      throw bad("a character in the header " + name + " that no header has", "visible ASCII and spaces");
    found.headers.push_back({name, filled});
  }
  return found;
}

Json load_body_fields(const std::string& path) {
  if (path.empty()) return Json();
  Json fields = parse_json(read_file(path, kMaxBodyBytes), path);
  if (!fields.is_object()) throw invalid_field(path, "/", fields, "an object: fields of a chat request");
  for (const auto& [name, value] : fields.items()) {
    if (kOwnFields.count(name) != 0)
      throw invalid_field(path, "/" + name, value, "a field that does not decide what is asked");
  }
  return fields;
}

}  // namespace physmas::remote
