// Optional fields of a record that is already valid.
#ifndef PHYSMAS_RECORDS_JSON_FIELDS_H
#define PHYSMAS_RECORDS_JSON_FIELDS_H

#include "records/json.h"

namespace physmas {

// Copies json[key] into `value` when it is there.
template <class T>
void read_if_present(const Json& json, const char* key, T& value) {
  if (json.contains(key)) value = json.at(key).get<T>();
}
inline void read_if_present(const Json& json, const char* key, Eigen::Vector3d& value) {
  if (json.contains(key)) value = vector3_from(json.at(key));
}

}  // namespace physmas

#endif
