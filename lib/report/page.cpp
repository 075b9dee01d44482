#include "report/page.h"

#include <fmt/format.h>

#include "base/embedded_text.h"
#include "base/error.h"
#include "base/hash.h"
#include "remote/base64.h"

namespace physmas::report {
namespace {

std::string pages(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += embedded_text("lib/report/pages/" + name);
  return text;
}

// As a content security policy names a text.
std::string source_hash(const std::string& text) {
  const std::string hex = sha256_text(text);
  std::string bytes;
  for (size_t i = 0; i < hex.size(); i += 2) bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return "'sha256-" + remote::base64_of(bytes) + "'";
}

}  // namespace

std::string escaped(const std::string& text) {
  // one_line() makes UTF-8 of anything.
  std::string out;
  for (const char c : one_line(text, text.size() + 1)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string data_address(const std::string& type, const std::string& bytes) {
  return "data:" + type + ";base64," + remote::base64_of(bytes);
}

std::string page_text(const Page& page) {
  const std::string style = pages(page.styles), script = pages(page.scripts);
  std::string policy =
      "default-src 'none'; img-src data:; media-src data: blob:; worker-src blob:; base-uri 'none'; form-action "
      "'none'; style-src " +
      source_hash(style);
  policy += script.empty() ? "" : "; script-src " + source_hash(script);
  std::string text = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  text += fmt::format("<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n", policy);
  text +=
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" "
      "content=\"light dark\">\n";
  text += "<link rel=\"icon\" href=\"data:,\">\n";
  text += "<title>" + escaped(page.title) + "</title>\n<style>" + style + "</style>\n</head>\n<body>\n" + page.body;
  if (!script.empty()) text += "<script>" + script + "</script>\n";
  return text + "</body>\n</html>\n";
}

}  // namespace physmas::report
