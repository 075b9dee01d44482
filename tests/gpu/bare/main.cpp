// The GPU's tests without the rest of the project. Usage: check [PART OF A NAME]
#include "doctest/doctest.h"

int main(int argc, char** argv) {
  return doctest::run(argc > 1 ? argv[1] : "") == 0 ? 0 : 1;
}
