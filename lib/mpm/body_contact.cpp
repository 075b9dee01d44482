#include "mpm/body_contact.h"

#include <algorithm>

namespace physmas::mpm {

int BodyContact::bodies() const {
  return body.empty() ? 1 : 1 + *std::max_element(body.begin(), body.end());
}

}  // namespace physmas::mpm
