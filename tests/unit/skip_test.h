// A test that cannot run says so: doctest has no skip of its own.
#ifndef PHYSMAS_TESTS_SKIP_TEST_H
#define PHYSMAS_TESTS_SKIP_TEST_H

#include <string>

// Call before returning from a test case for want of a file or a right. The test's name and the reason are printed
// after doctest's summary, which counts the test as passed.
void skip_test(const std::string& reason);

#endif
