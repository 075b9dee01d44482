// Materials of points in USD's text format.
#ifndef PHYSMAS_BUNDLE_USDA_POINTS_H
#define PHYSMAS_BUNDLE_USDA_POINTS_H

#include <string>

#include "bundle/material_files.h"

namespace physmas::bundle {

// Whether the bytes start as a layer in text does.
bool is_usda(const std::string& bytes);

// All prims of the layer that have points and, of each, yms (Pa), prs and rhos (kg/m^3): attributes of that name or
// primvars, one number per point or one for all. Read are default values of this layer; what it refers to in other
// files, variants and time samples are not. Errors (exit code 3): text that is no layer, a prim with some of these only
// or with numbers that do not fit its points, one that is moved by a transform of its own or of one above it, none at
// all.
MaterialSamples parse_usda_samples(const std::string& text, const std::string& file);

}  // namespace physmas::bundle

#endif
