#include "remote/key_mask.h"

#include <doctest/doctest.h>

using physmas::remote::KeyMask;

TEST_CASE("key mask: any case and any spelling") {
  const KeyMask mask("pmKey-1/x");
  CHECK(mask.masked("a PMKEY-1/X b pmkey-1/x") == "a [key] b [key]");
  CHECK(mask.masked("nothing of it") == "nothing of it");
  for (const char* hidden : {"pm\\u004bey-1/x", "pmkey-1\\/x", "pmKey%2D1%2fx", "\\u0070mKEY-1\\/x"}) {
    CHECK(mask.is_in(hidden));
    CHECK(mask.masked(std::string("before ") + hidden) == "[key]");
  }
  CHECK_FALSE(mask.is_in("pmKey-1"));
  CHECK_FALSE(mask.is_in("%zz \\u00 \\"));
}

TEST_CASE("key mask: no key, and one that is a part of what stands for it") {
  CHECK_FALSE(KeyMask("").is_in(""));
  CHECK(KeyMask("").masked("text") == "text");
  CHECK(KeyMask("key").masked("the key") == "the [key]");
  CHECK(KeyMask("KEY").masked("the key") == "the [key]");
}
