// PhysGaussian's configuration files.
#include "scene/physgaussian.h"

#include "guard.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  physmas::guard([&] {
    const auto import = physmas::physgaussian_from(physmas::parse_json(text, "input.json"), "input.json");
    physmas::material_hints(import, {});
  });
  return 0;
}
