// What the GPU's tests use of doctest, for machines that have no doctest (check.sh).
#ifndef PHYSMAS_TESTS_GPU_BARE_DOCTEST_H
#define PHYSMAS_TESTS_GPU_BARE_DOCTEST_H

#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace doctest {

struct Test {
  const char* name;
  void (*run)();
};
inline std::vector<Test> tests;
inline int checks = 0, failures = 0;
inline int subcase_wanted = 0, subcases_seen = 0;
inline std::string captured;

struct Registration {
  Registration(const char* name, void (*run)()) { tests.push_back({name, run}); }
};
struct Required : std::exception {};

inline bool check(bool good, const char* text, int line) {
  ++checks;
  if (good) return true;
  ++failures;
  std::printf("  line %d: CHECK( %s ) failed%s\n", line, text, captured.c_str());
  return false;
}
// Subcases of a test do not hold others.
inline bool enters() {
  return subcases_seen++ == subcase_wanted;
}

class Approx {
 public:
  explicit Approx(double value) : value_(value) {}
  Approx& epsilon(double share) {
    share_ = share;
    return *this;
  }
  friend bool operator==(double a, const Approx& b) {
    return std::fabs(a - b.value_) < b.share_ * (1 + std::fmax(std::fabs(a), std::fabs(b.value_)));
  }

 private:
  double value_, share_ = 1.2e-5;
};

template <class T>
std::string shown(const T& value) {
  if constexpr (std::is_arithmetic_v<T>)
    return std::to_string(value);
  else
    return std::string(value);
}
struct Capture {
  explicit Capture(const std::string& text) : before(captured) { captured += ", " + text; }
  ~Capture() { captured = before; }
  std::string before;
};

// The tests whose names hold `filter`; returns the number of those that failed.
inline int run(const std::string& filter) {
  int failed = 0, ran = 0;
  for (const Test& test : tests) {
    if (std::string(test.name).find(filter) == std::string::npos) continue;
    const int before = failures;
    ++ran;
    subcase_wanted = 0;
    do {
      subcases_seen = 0;
      captured.clear();
      try {
        test.run();
      } catch (const Required&) {
      } catch (const std::exception& error) {
        ++failures;
        std::printf("  %s\n", error.what());
      }
    } while (++subcase_wanted < subcases_seen);
    failed += failures > before ? 1 : 0;
    std::printf("%s: %s\n", test.name, failures > before ? "FAILED" : "passed");
    std::fflush(stdout);
  }
  std::printf("%d tests, %d failed; %d checks, %d failed\n", ran, failed, checks, failures);
  return ran == 0 ? 1 : failed;
}

}  // namespace doctest

#define PM_JOIN_2(a, b) a##b
#define PM_JOIN(a, b) PM_JOIN_2(a, b)
#define PM_TEST(name, function)                                                      \
  static void function();                                                            \
  static const doctest::Registration PM_JOIN(function, _registered)(name, function); \
  static void function()
#define TEST_CASE(name) PM_TEST(name, PM_JOIN(test_at_, __LINE__))
#define SUBCASE(name) if (doctest::enters())
#define CHECK(...) doctest::check(static_cast<bool>(__VA_ARGS__), #__VA_ARGS__, __LINE__)
#define REQUIRE(...) \
  if (!doctest::check(static_cast<bool>(__VA_ARGS__), #__VA_ARGS__, __LINE__)) throw doctest::Required()
#define CAPTURE(value) const doctest::Capture PM_JOIN(captured_at_, __LINE__)(#value " = " + doctest::shown(value))

#endif
