// Gaussian scenes from primitives.
#ifndef PHYSMAS_BUNDLE_SYNTH_H
#define PHYSMAS_BUNDLE_SYNTH_H

#include <cstdint>
#include <vector>

#include "records/example.h"
#include "records/inventory.h"
#include "scene/gaussians.h"

namespace physmas::bundle {

struct SynthScene {
  Gaussians gaussians;       // scene space, spherical harmonics of degree 0
  std::vector<int32_t> row;  // [N] the true row of every Gaussian, index into inventory.rows
  Inventory inventory;       // authored, without appearance hints
};

// Covers every surface with flat Gaussians that lie along it. The same example gives the same Gaussians, bit for bit,
// on any machine: values are rounded to multiples of 2^-20. Where shapes of one part overlap, the hidden pieces are
// left out. file: the example's, for messages. Throws an Error (exit code 3) when a part keeps no Gaussian, or when the
// spacing asks for more than two million of them.
SynthScene synthesize(const Example& example, const std::string& file);

}  // namespace physmas::bundle

#endif
