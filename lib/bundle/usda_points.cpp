#include "bundle/usda_points.h"

#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace physmas::bundle {
namespace {

constexpr const char* kLayerMark = "#usda ";
constexpr int kMostNested = 128;  // prims inside prims
constexpr size_t kMostPrims = 1000000;
constexpr size_t kMostNumbers = 6 * kMaxFieldSamples;  // of all attributes that count

// What of a prim counts here.
struct PrimNumbers {
  std::string name;
  size_t parent = 0;  // among all prims; the layer itself is the first one and its own parent
  bool moved = false;
  std::optional<std::vector<double>> points, E, nu, rho;
};

class UsdaReader {
 public:
  UsdaReader(const std::string& text, const std::string& file) : text_(text), file_(file) {}

  MaterialSamples read() {
    at_ = std::strlen(kLayerMark);
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    skip_space();
    if (peek() == '(') skip_brackets();
    prims_.emplace_back();
    read_body(0, 0);
    // Only now is it known what moves them.
    for (size_t i = 1; i < prims_.size(); ++i) {
      prims_[i].moved |= prims_[prims_[i].parent].moved;
      take(prims_[i]);
    }
    if (samples_.position.empty())
      throw invalid_input({file_, "", "no prim with points, yms, prs and rhos", "one",
                           "values from other files count after usdcat --flatten"});
    return std::move(samples_);
  }

 private:
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  [[noreturn]] void fail(const std::string& expected) const {
    long line = 1;
    for (size_t i = 0; i < at_ && i < text_.size(); ++i) line += text_[i] == '\n';
    const std::string found =
        at_ < text_.size() ? "\"" + one_line(text_.substr(at_, 40), 40) + "\"" : std::string("the end of the file");
    throw invalid_input({file_, fmt::format("line {}", line), found, expected});
  }

  // Spaces, ends of lines and comments; of one line only where `line` says so.
  void skip_space(bool line = false) {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      } else if (c == ' ' || c == '\t' || c == '\r' || (!line && (c == '\n' || c == ';'))) {
        ++at_;
      } else {
        break;
      }
    }
  }

  // A text in quotes, of one kind or three of it; returns what stands in it, as it stands.
  std::string_view quoted() {
    const char quote = text_[at_];
    const bool triple = text_.compare(at_, 3, std::string(3, quote)) == 0;
    const size_t length = triple ? 3 : 1, start = at_ + length;
    for (size_t i = start; i < text_.size(); ++i) {
      if (text_[i] == '\\') {
        ++i;
      } else if (text_[i] == quote && (!triple || text_.compare(i, 3, std::string(3, quote)) == 0)) {
        at_ = i + length;
        return std::string_view(text_).substr(start, i - start);
      }
    }
    fail("the end of a text in quotes");
  }

  // From an opening bracket behind the one that closes it.
  void skip_brackets() {
    std::string open;
    do {
      skip_space();
      const char c = peek();
      if (c == '(' || c == '[' || c == '{') {
        open += c;
        ++at_;
      } else if (c == ')' || c == ']' || c == '}') {
        const char opened = open.back();
        if (c != (opened == '(' ? ')' : opened == '[' ? ']' : '}')) fail("brackets that match");
        open.pop_back();
        ++at_;
      } else {
        skip_plain();
      }
    } while (!open.empty());
  }

  // One piece of a value that is no bracket.
  void skip_plain() {
    const char c = peek();
    if (c == '"' || c == '\'') {
      quoted();
    } else if (c == '@' || c == '<') {
      const std::string end = c == '<' ? ">" : text_.compare(at_, 3, "@@@") == 0 ? "@@@" : "@";
      const size_t found = text_.find(end, at_ + end.size());
      if (found == std::string::npos) fail("the end of a path");
      at_ = found + end.size();
    } else if (at_ >= text_.size()) {
      fail("a bracket that closes");
    } else {
      ++at_;
    }
  }

  std::string word() {
    const size_t start = at_;
    while (at_ < text_.size() && std::strchr(" \t\r\n;=(){}\"'@<#", text_[at_]) == nullptr) ++at_;
    if (at_ == start) fail("a word");
    return text_.substr(start, at_ - start);
  }

  // One number or brackets full of them, in their order.
  std::vector<double> numbers(const std::string& attribute) {
    std::vector<double> values;
    int open = 0;
    do {
      skip_space();
      const char c = peek();
      if (c == '[' || c == '(') {
        if (++open > 2) fail("a number");
        ++at_;
      } else if (open > 0 && (c == ']' || c == ')')) {
        --open;
        ++at_;
      } else if (open > 0 && c == ',') {
        ++at_;
      } else {
        double value = 0;
        const char* const end = text_.data() + text_.size();
        const auto [behind, status] = std::from_chars(text_.data() + at_, end, value);
        if (status == std::errc::invalid_argument) fail("a number of " + attribute);
        // What no double holds is none that counts.
        values.push_back(status == std::errc() ? value : std::numeric_limits<double>::quiet_NaN());
        at_ = static_cast<size_t>(behind - text_.data());
        if (++numbers_ > kMostNumbers)
          throw invalid_input({file_, attribute, "more numbers", fmt::format("at most {} samples", kMaxFieldSamples)});
      }
    } while (open > 0);
    return values;
  }

  void read_attribute(PrimNumbers& prim) {
    std::string name, behind;
    // Behind a name stands its value, what is known of it, or the end of the line.
    while (peek() != '\0' && std::strchr("=(\n;}", peek()) == nullptr) {
      name = word();
      skip_space(true);
    }
    if (peek() == '=') {
      ++at_;
      skip_space();
      if (name.compare(0, 8, "primvars") == 0 && name.size() > 9) name.erase(0, 9);
      std::optional<std::vector<double>>* wanted = name == "points" ? &prim.points
                                                   : name == "yms"  ? &prim.E
                                                   : name == "prs"  ? &prim.nu
                                                   : name == "rhos" ? &prim.rho
                                                                    : nullptr;
      if (name == "xformOpOrder") {
        const size_t start = at_;
        skip_value();
        prim.moved = text_.substr(start, at_ - start).find('"') != std::string::npos;
      } else if (wanted != nullptr && text_.compare(at_, 4, "None") != 0) {
        *wanted = numbers(path_of(prim) + "." + name);
      } else {
        skip_value();
      }
      skip_space(true);
    }
    if (peek() == '(') skip_brackets();
  }

  void skip_value() {
    if (peek() != '\0' && std::strchr("([{", peek()) != nullptr)
      skip_brackets();
    else
      do skip_plain();
      while (at_ < text_.size() && std::strchr(" \t\r\n;()", text_[at_]) == nullptr);
  }

  // Prims and attributes up to the end of a prim, or of the file. Every byte is read once.
  void read_body(size_t self, int depth) {
    if (depth > kMostNested) fail(fmt::format("at most {} prims inside each other", kMostNested));
    for (skip_space(); peek() != '}'; skip_space()) {
      if (at_ >= text_.size()) {
        if (depth > 0) fail("the end of " + path_of(prims_[self]));
        return;
      }
      const size_t statement = at_;
      const std::string first = word();
      if (first == "def" || first == "over" || first == "class") {
        skip_space();
        if (peek() != '"' && peek() != '\'') word();
        skip_space();
        if (peek() != '"' && peek() != '\'') fail("a prim's name in quotes");
        PrimNumbers prim;
        prim.name = one_line(std::string(quoted()), 80);
        prim.parent = self;
        skip_space();
        if (peek() == '(') skip_brackets();
        skip_space();
        if (peek() != '{') fail("the body of " + path_of(prim));
        ++at_;
        prims_.push_back(std::move(prim));
        if (prims_.size() > kMostPrims) fail(fmt::format("at most {} prims", kMostPrims));
        read_body(prims_.size() - 1, depth + 1);
        ++at_;
      } else if (first == "variantSet") {
        while (at_ < text_.size() && peek() != '{') skip_plain();
        if (peek() != '{') fail("a variant set");
        skip_brackets();
      } else {
        at_ = statement;
        read_attribute(prims_[self]);
      }
    }
    if (depth == 0) fail("an attribute or a prim");
  }

  std::string path_of(const PrimNumbers& prim) const {
    std::string path = "/" + prim.name;
    for (size_t i = prim.parent; i != 0; i = prims_[i].parent) path = "/" + prims_[i].name + path;
    return path;
  }

  void take(const PrimNumbers& prim) {
    if (!prim.E && !prim.nu && !prim.rho) return;
    if (!prim.points || !prim.E || !prim.nu || !prim.rho)
      throw invalid_input({file_, path_of(prim),
                           fmt::format("no {}", !prim.points ? "points"
                                                : !prim.E    ? "yms"
                                                : !prim.nu   ? "prs"
                                                             : "rhos"),
                           "points, yms, prs and rhos in the same prim"});
    if (prim.moved)
      throw invalid_input({file_, path_of(prim), "a transform (xformOpOrder) of it or of a prim above it", "none",
                           "write the points where they are, in the coordinates of the Gaussians"});
    if (prim.points->size() % 3 != 0)
      throw invalid_input(
          {file_, path_of(prim) + ".points", fmt::format("{} coordinates", prim.points->size()), "three each"});
    const size_t n = prim.points->size() / 3;
    for (const auto& [values, name] :
         {std::pair(&*prim.E, "yms"), std::pair(&*prim.nu, "prs"), std::pair(&*prim.rho, "rhos")}) {
      if (values->size() != n && values->size() != 1)
        throw invalid_input({file_, path_of(prim) + "." + name, fmt::format("{} values", values->size()),
                             fmt::format("{}, one per point, or one for all", n)});
    }
    if (samples_.position.size() + n > kMaxFieldSamples)
      throw invalid_input({file_, path_of(prim), fmt::format("{} samples", samples_.position.size() + n),
                           fmt::format("at most {}", kMaxFieldSamples)});
    for (size_t i = 0; i < n; ++i) {
      samples_.position.push_back({(*prim.points)[3 * i], (*prim.points)[3 * i + 1], (*prim.points)[3 * i + 2]});
      samples_.E.push_back((*prim.E)[prim.E->size() == 1 ? 0 : i]);
      samples_.nu.push_back((*prim.nu)[prim.nu->size() == 1 ? 0 : i]);
      samples_.rho.push_back((*prim.rho)[prim.rho->size() == 1 ? 0 : i]);
    }
  }

  const std::string& text_;
  const std::string& file_;
  size_t at_ = 0, numbers_ = 0;
  std::vector<PrimNumbers> prims_;
  MaterialSamples samples_;
};

}  // namespace

bool is_usda(const std::string& bytes) {
  return bytes.compare(0, std::strlen(kLayerMark), kLayerMark) == 0;
}

MaterialSamples parse_usda_samples(const std::string& text, const std::string& file) {
  return UsdaReader(text, file).read();
}

}  // namespace physmas::bundle
