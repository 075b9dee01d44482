// CLIP's byte-pair encoding.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/error.h"
#include "base/file.h"
#include "metrics/clip.h"

namespace physmas::metrics {
namespace {

constexpr size_t kMerges = 49152 - 256 - 2;
constexpr size_t kMaxFile = size_t{16} << 20;
const std::string kEnd = "</w>", kStartToken = "<|startoftext|>", kEndToken = "<|endoftext|>";

std::string utf8(int code) {
  if (code < 0x80) return std::string(1, static_cast<char>(code));
  return {static_cast<char>(0xc0 | code >> 6), static_cast<char>(0x80 | (code & 0x3f))};
}

// Every byte as one printable character, in the order of the vocabulary: printable ones first, as themselves.
std::vector<std::string> byte_characters() {
  std::vector<std::string> list;
  std::vector<bool> printable(256, false);
  for (const auto& [first, last] : {std::pair{'!' + 0, '~' + 0}, {0xa1, 0xac}, {0xae, 0xff}}) {
    for (int b = first; b <= last; ++b) {
      list.push_back(utf8(b));
      printable[b] = true;
    }
  }
  int next = 256;
  for (int b = 0; b < 256; ++b) {
    if (!printable[b]) list.push_back(utf8(next++));
  }
  return list;
}

// CLIP's pattern on ASCII: contractions, runs of letters, single digits, runs of anything else that is not a space.
std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  const auto letter = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  for (size_t i = 0; i < text.size();) {
    size_t end = i + 1;
    const auto contraction = [&]() -> size_t {
      for (const char* c : {"'s", "'t", "'re", "'ve", "'m", "'ll", "'d"}) {
        const std::string suffix = c;
        if (text.compare(i, suffix.size(), suffix) == 0) return suffix.size();
      }
      return 0;
    };
    if (space(text[i])) {
      ++i;
      continue;
    }
    if (const size_t length = contraction()) {
      end = i + length;
    } else if (letter(text[i])) {
      while (end < text.size() && letter(text[end])) ++end;
    } else if (!digit(text[i])) {
      while (end < text.size() && !letter(text[end]) && !digit(text[end]) && !space(text[end])) ++end;
    }
    words.push_back(text.substr(i, end - i));
    i = end;
  }
  return words;
}

}  // namespace

ClipTokenizer load_clip_tokenizer(const std::string& path) {
  return ClipTokenizer(read_file(path, kMaxFile), path);
}

ClipTokenizer::ClipTokenizer(const std::string& merges, const std::string& file) {
  if (merges.compare(0, 2, "\x1f\x8b") == 0)
    throw invalid_input({file, "", "a gzip file", "text", "unpack it with gunzip"});
  int64_t next = 0;
  const std::vector<std::string> characters = byte_characters();
  for (const std::string& c : characters) id_[c] = next++;
  for (const std::string& c : characters) id_[c + kEnd] = next++;
  size_t at = merges.find('\n'), line = 1;
  while (at != std::string::npos && at + 1 < merges.size() && rank_.size() < kMerges) {
    size_t end = merges.find('\n', at + 1);
    if (end == std::string::npos) end = merges.size();
    std::string text = merges.substr(at + 1, end - at - 1);
    if (!text.empty() && text.back() == '\r') text.pop_back();
    ++line;
    const size_t gap = text.find(' ');
    if (gap == 0 || gap == std::string::npos || gap + 1 == text.size() || text.find(' ', gap + 1) != std::string::npos)
      throw invalid_input({file, fmt::format("line {}", line), one_line(text, 40), "two parts and a space between"});
    const std::string left = text.substr(0, gap), right = text.substr(gap + 1);
    if (!rank_.emplace(std::pair(left, right), static_cast<int>(rank_.size())).second)
      throw invalid_input({file, fmt::format("line {}", line), one_line(text, 40), "each pair once"});
    id_[left + right] = next++;
    at = end;
  }
  if (rank_.empty()) throw invalid_input({file, "", "no merges", "a line that is skipped, then a pair per line"});
  id_[kStartToken] = next++;
  id_[kEndToken] = next;
}

std::vector<std::string> ClipTokenizer::split_word(const std::string& word) const {
  std::vector<std::string> parts;
  for (const char c : word) parts.emplace_back(1, c);
  parts.back() += kEnd;
  for (;;) {
    const std::pair<const std::pair<std::string, std::string>, int>* best = nullptr;
    for (size_t i = 0; i + 1 < parts.size(); ++i) {
      const auto found = rank_.find({parts[i], parts[i + 1]});
      if (found != rank_.end() && (best == nullptr || found->second < best->second)) best = &*found;
    }
    if (best == nullptr) return parts;
    std::vector<std::string> merged;
    for (size_t i = 0; i < parts.size(); ++i) {
      const bool pair = i + 1 < parts.size() && parts[i] == best->first.first && parts[i + 1] == best->first.second;
      merged.push_back(pair ? parts[i] + parts[i + 1] : parts[i]);
      if (pair) ++i;
    }
    parts = std::move(merged);
  }
}

std::vector<int64_t> ClipTokenizer::encode(const std::string& prompt) const {
  std::string text;
  for (const char c : prompt) {
    if (static_cast<unsigned char>(c) >= 0x80)
      throw invalid_input({"the prompt", "", one_line(prompt, 60), "ASCII text", "give embeddings from a file"});
    text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  std::vector<int64_t> ids = {id_.at(kStartToken)};
  for (const std::string& word : words_of(text)) {
    for (const std::string& part : split_word(word)) {
      const auto found = id_.find(part);
      // A control character stands in the vocabulary under another name; prompts have none.
      if (found == id_.end()) throw invalid_input({"the prompt", "", "a control character", "printable text"});
      ids.push_back(found->second);
    }
  }
  ids.push_back(id_.at(kEndToken));
  if (ids.size() > kClipContext)
    throw invalid_input(
        {"the prompt", "", fmt::format("{} tokens", ids.size() - 2), fmt::format("at most {}", kClipContext - 2)});
  ids.resize(kClipContext, 0);
  return ids;
}

}  // namespace physmas::metrics
