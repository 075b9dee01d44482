// PhysGaussian's configuration files.
#include "bundle/physgaussian.h"

#include "guard.h"
#include "records/json.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  physmas::guard([&] {
    const auto import = physmas::bundle::physgaussian_from(physmas::parse_json(text, "input.json"), "input.json");
    physmas::bundle::material_hints(import, {});
  });
  return 0;
}
