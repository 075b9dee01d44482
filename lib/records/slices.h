// Slices of a scene: what one stage depends on, so that a change to anything else leaves the stage alone.
#ifndef PHYSMAS_RECORDS_SLICES_H
#define PHYSMAS_RECORDS_SLICES_H

#include <string>

#include "records/json_fwd.h"

namespace physmas {

// Cuts the scene of `scene_path` into one slice per stage under `folder` (ground.json, lift.json, ...), each rewritten
// only when its content changes. What a slice holds of the run specification, run_fields.h says; the render slice has
// the floor's place as well where the picture needs it. `overrides`: a run object whose fields win over the scene's;
// `defaults`: one over whose fields the scene's win (JSON merge patches, RFC 7396). Where the camera is fitted,
// camera.mk says so to make: PM_CAMERA := fit (or orbit). prompt: instead of the scene's; empty: the scene's. A bad one is an
// Error (exit code 3).
void write_slices(const std::string& scene_path, const Json& overrides, const Json& defaults, const std::string& prompt,
                  const std::string& folder);

}  // namespace physmas

#endif
