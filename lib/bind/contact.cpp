#include "bind/contact.h"

#include <algorithm>
#include <string>

#include "records/reference.h"

namespace physmas::bind {

std::vector<int> bind_objects(const State& state) {
  std::vector<std::string> known;
  std::vector<int> objects;
  for (const std::string& key : state.row_keys) {
    const std::string object = object_of(key);
    const auto at = std::find(known.begin(), known.end(), object);
    objects.push_back(static_cast<int>(at - known.begin()));
    if (at == known.end()) known.push_back(object);
  }
  return objects;
}

mpm::BodyContact bind_contact(const State& state, const RunSpecification::Contact& contact) {
  mpm::BodyContact bound;
  if (!contact.separates()) return bound;
  bound.friction = contact.friction_between();
  std::vector<bool> present(state.row_keys.size(), false);
  for (const int32_t row : state.row) present[row] = true;
  std::vector<std::string> objects;
  for (size_t r = 0; r < state.row_keys.size(); ++r) {
    const std::string object = object_of(state.row_keys[r]);
    const auto known = std::find(objects.begin(), objects.end(), object);
    const auto body = static_cast<int>(known - objects.begin());
    bound.body.push_back(present[r] ? std::min(body, mpm::kMostBodies - 1) : 0);
    if (present[r] && known == objects.end()) objects.push_back(object);
  }
  if (objects.size() < 2) bound.body.clear();
  return bound;
}

}  // namespace physmas::bind
