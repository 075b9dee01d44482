// The C++ tests: one binary, doctest, and after its summary the tests that were skipped.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>
#include <vector>

#include "unit/skip_test.h"

namespace {

std::vector<std::string> skipped;

}  // namespace

void skip_test(const std::string& reason) {
  skipped.push_back(std::string(doctest::getContextOptions()->currentTest->m_name) + ": " + reason);
}

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  const int status = context.run();
  for (const std::string& test : skipped) std::printf("skipped: %s\n", test.c_str());
  if (!skipped.empty()) std::printf("%zu of the passed tests were skipped\n", skipped.size());
  return status;
}
