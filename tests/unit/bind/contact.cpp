// Objects as bodies of the solver.
#include "bind/contact.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace physmas;

namespace {

State state_of(const std::vector<std::string>& keys, const std::vector<int32_t>& rows) {
  State state;
  state.row_keys = keys;
  state.row = rows;
  return state;
}

RunSpecification::Contact separate() {
  RunSpecification::Contact contact;
  contact.objects = RunSpecification::Contact::Objects::separate;
  return contact;
}

}  // namespace

TEST_CASE("bind: rows of an object are one body, in the order of the rows; without particles an object is none") {
  const State state = state_of(
      {"cake/top", "ghost/part", "cake/base", "hammer/head", "cake/residual", "hammer/residual"}, {0, 2, 3, 3, 4, 5});
  CHECK(bind::bind_contact(state, separate()).body == std::vector<int>{0, 0, 0, 1, 0, 1});
  CHECK(bind::bind_contact(state, separate()).friction == 0.4);
  RunSpecification::Contact smooth = separate();
  smooth.friction = 0;
  CHECK(bind::bind_contact(state, smooth).friction == 0);
  CHECK(bind::bind_contact(state, {}).body.empty());
  CHECK(bind::bind_contact(state_of({"cake/top", "cake/base", "hammer/head"}, {0, 1}), separate()).body.empty());
}

TEST_CASE("bind: more objects than the solver has fields share the last one") {
  std::vector<std::string> keys;
  std::vector<int32_t> rows;
  for (int i = 0; i < mpm::kMostBodies + 3; ++i) {
    keys.push_back("object" + std::to_string(i) + "/part");
    rows.push_back(i);
  }
  const std::vector<int> body = bind::bind_contact(state_of(keys, rows), separate()).body;
  for (int i = 0; i < mpm::kMostBodies + 3; ++i) CHECK(body[i] == std::min(i, mpm::kMostBodies - 1));
}
