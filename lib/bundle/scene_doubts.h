// What makes a scene look empty or of one colour, in words.
#ifndef PHYSMAS_BUNDLE_SCENE_DOUBTS_H
#define PHYSMAS_BUNDLE_SCENE_DOUBTS_H

#include <string>
#include <vector>

#include "scene/gaussians.h"
#include "scene/image.h"

namespace physmas::bundle {

// One warning at most: Gaussians as large as the scene, opacities near nothing, a single Gaussian, or, from the
// pictures of its views (RGBA, alpha as rendered), a view that is blank or of one colour. Each names the likely cause
// and the option that mends it. Empty: nothing to say.
std::string scene_doubt(const Gaussians& gaussians, const std::vector<Image>& views);

}  // namespace physmas::bundle

#endif
