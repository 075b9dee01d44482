// Names that a schema lets through, as indices of their tables.
#ifndef PHYSMAS_RECORDS_NAMES_H
#define PHYSMAS_RECORDS_NAMES_H

#include <algorithm>
#include <string>

#include "base/error.h"

namespace physmas {

// The index of `name` in `names`, all that the schema allows; another one is a fault of ours.
template <class Names>
int index_of(const Names& names, const std::string& name) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) throw internal_error("a name that the schema should have refused: " + name);
  return static_cast<int>(at - names.begin());
}

}  // namespace physmas

#endif
