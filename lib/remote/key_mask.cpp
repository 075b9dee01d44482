#include "remote/key_mask.h"

#include <algorithm>
#include <cctype>

namespace physmas::remote {
namespace {

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

size_t find_any_case(const std::string& text, const std::string& key, size_t from) {
  const auto at = std::search(text.begin() + static_cast<std::ptrdiff_t>(from), text.end(), key.begin(), key.end(),
                              [](char a, char b) { return lower(a) == lower(b); });
  return at == text.end() ? std::string::npos : static_cast<size_t>(at - text.begin());
}

// The value of `digits` hexadecimal digits, -1 where there are other characters.
int hexadecimal(const std::string& text, size_t at, size_t digits) {
  if (at + digits > text.size()) return -1;
  int value = 0;
  for (size_t i = at; i < at + digits; ++i) {
    const char c = lower(text[i]);
    if (!std::isxdigit(static_cast<unsigned char>(c))) return -1;
    value = 16 * value + (c <= '9' ? c - '0' : c - 'a' + 10);
  }
  return value;
}

// Without the escapes of JSON and of URLs, as far as they stand for ASCII.
std::string unescaped(const std::string& text) {
  std::string plain;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool json = text[i] == '\\' && i + 1 < text.size();
    const bool unicode = json && text[i + 1] == 'u';
    const int code = unicode ? hexadecimal(text, i + 2, 4) : text[i] == '%' ? hexadecimal(text, i + 1, 2) : -1;
    if (code >= 0 && code < 0x80) {
      plain += static_cast<char>(code);
      i += unicode ? 5 : 2;
    } else if (json && !unicode) {
      plain += text[++i];
    } else {
      plain += text[i];
    }
  }
  return plain;
}

}  // namespace

bool KeyMask::is_in(const std::string& text) const {
  return !key_.empty() && (find_any_case(text, key_, 0) != std::string::npos ||
                           find_any_case(unescaped(text), key_, 0) != std::string::npos);
}

std::string KeyMask::masked(const std::string& text) const {
  if (key_.empty()) return text;
  std::string clean;
  size_t from = 0;
  for (size_t at; (at = find_any_case(text, key_, from)) != std::string::npos; from = at + key_.size())
    clean += text.substr(from, at - from) + shown_;
  clean += text.substr(from);
  return find_any_case(unescaped(clean), key_, 0) == std::string::npos ||
                 find_any_case(shown_, key_, 0) != std::string::npos
             ? clean
             : shown_;
}

bool KeyMasks::is_in(const std::string& text) const {
  return std::any_of(masks_.begin(), masks_.end(), [&](const KeyMask& mask) { return mask.is_in(text); });
}

std::string KeyMasks::masked(std::string text) const {
  for (const KeyMask& mask : masks_) text = mask.masked(text);
  return text;
}

}  // namespace physmas::remote
