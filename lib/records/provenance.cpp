#include "records/provenance.h"

#include "base/hash.h"

namespace physmas {

void Provenance::add_input(const std::string& path) {
  inputs.push_back({path, sha256_file(path)});
}

std::string Provenance::sha256_of(const std::string& path) const {
  for (const Input& input : inputs) {
    if (input.path == path) return input.sha256;
  }
  return "";
}

}  // namespace physmas
