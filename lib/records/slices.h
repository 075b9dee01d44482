// Slices of a scene: what one stage depends on, so that a change to anything else leaves the stage alone.
#ifndef PHYSMAS_RECORDS_SLICES_H
#define PHYSMAS_RECORDS_SLICES_H

#include <string>

#include "records/json_fwd.h"

namespace physmas {

// Cuts the scene of `scene_path` into one slice per stage under `folder` (ground.json, lift.json, ...), each rewritten
// only when its content changes. What a slice holds of the run specification, run_fields.h says. `overrides`: a run
// object whose fields win over the scene's (JSON merge patch, RFC 7396). prompt: instead of the scene's; empty: the
// scene's. A blank one is an Error (exit code 3).
void write_slices(const std::string& scene_path, const Json& overrides, const std::string& prompt,
                  const std::string& folder);

}  // namespace physmas

#endif
