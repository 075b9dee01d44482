// Runs a fuzz target without libFuzzer: TARGET FILE-OR-FOLDER... [-max_total_time=SECONDS] [-runs=N] [-seed=N].
// Without a time it replays the files once. With one it mutates them at random, without guidance by coverage, until the
// time is over, or N mutations have been tried. The input that a sanitizer or an abort stopped at is left in
// crash-input.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "guard.h"

// Absent in a build without sanitizers.
extern "C" __attribute__((weak)) void __sanitizer_set_death_callback(void (*callback)());

namespace {

std::string current;  // the input under test

void save_current() {
  std::ofstream("crash-input", std::ios::binary) << current;
  std::fprintf(stderr, "the input is in crash-input (%zu bytes)\n", current.size());
}

void on_abort(int) {
  save_current();
  std::_Exit(1);
}

void test(const std::string& input) {
  current = input;
  LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(current.data()), current.size());
}

class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  size_t below(size_t n) { return n == 0 ? 0 : random_() % n; }

  std::string operator()(const std::vector<std::string>& corpus) {
    std::string s = corpus[below(corpus.size())];
    for (size_t rounds = 1 + below(6); rounds > 0; --rounds) mutate(s, corpus[below(corpus.size())]);
    if (s.size() > kMaxBytes) s.resize(kMaxBytes);
    return s;
  }

 private:
  static constexpr size_t kMaxBytes = 1 << 16;

  void mutate(std::string& s, const std::string& other) {
    static const std::vector<std::string> kTokens = {"0",
                                                     "-1",
                                                     "1e308",
                                                     "1e-320",
                                                     "nan",
                                                     "inf",
                                                     "18446744073709551615",
                                                     "4294967296",
                                                     "null",
                                                     "{}",
                                                     "[]",
                                                     "\"\"",
                                                     "true",
                                                     std::string(4, '\xff'),
                                                     std::string(8, '\0'),
                                                     std::string("\0\0\x80\x7f", 4),
                                                     "\n",
                                                     " ",
                                                     "2147483648"};
    const size_t at = below(s.size() + 1);
    switch (below(8)) {
      case 0:
        if (at < s.size()) s[at] = static_cast<char>(s[at] ^ 1 << below(8));
        break;
      case 1:
        if (at < s.size()) s[at] = static_cast<char>(random_());
        break;
      case 2:
        s.erase(at, 1 + below(16));
        break;
      case 3:
        s.insert(at, kTokens[below(kTokens.size())]);
        break;
      case 4: {  // overwrite
        const std::string& token = kTokens[below(kTokens.size())];
        s.replace(at, std::min(token.size(), s.size() - at), token);
        break;
      }
      case 5:  // repeat a piece of itself
        s.insert(at, s.substr(below(s.size() + 1), 1 + below(64)));
        break;
      case 6:  // a piece of another input
        s.insert(at, other.substr(below(other.size() + 1), 1 + below(64)));
        break;
      default:
        s.resize(at);
    }
  }

  std::mt19937_64 random_;
};

}  // namespace

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  double seconds = 0;
  size_t mutations = SIZE_MAX;
  unsigned seed = 1;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.rfind("-max_total_time=", 0) == 0) {
      seconds = std::atof(argument.c_str() + 16);
    } else if (argument.rfind("-runs=", 0) == 0) {
      mutations = std::strtoull(argument.c_str() + 6, nullptr, 10);
    } else if (argument.rfind("-seed=", 0) == 0) {
      seed = static_cast<unsigned>(std::atol(argument.c_str() + 6));
    } else if (fs::is_directory(argument)) {
      for (const auto& entry : fs::directory_iterator(argument)) files.push_back(entry.path().string());
    } else if (argument[0] != '-') {
      files.push_back(argument);
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const std::string& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  if (corpus.empty()) {
    std::fprintf(stderr, "no inputs\n");
    return 2;
  }
  std::signal(SIGABRT, on_abort);
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(save_current);
  for (const std::string& input : corpus) test(input);
  Mutator mutate(seed);
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  size_t runs = corpus.size();
  for (size_t i = 0; i < mutations && Clock::now() < end; ++i, ++runs) test(mutate(corpus));
  std::printf("%zu inputs, nothing found\n", runs);
  return 0;
}
