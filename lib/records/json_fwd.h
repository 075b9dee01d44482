// The name of a JSON value, for headers that only pass it on.
#ifndef PHYSMAS_RECORDS_JSON_FWD_H
#define PHYSMAS_RECORDS_JSON_FWD_H

#include <nlohmann/json_fwd.hpp>

namespace physmas {

// Insertion order is kept: evidence ties follow it, and files stay readable.
using Json = nlohmann::ordered_json;

}  // namespace physmas

#endif
