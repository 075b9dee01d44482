// The final audit of the accepted candidate.
#ifndef PHYSMAS_SCREEN_AUDIT_H
#define PHYSMAS_SCREEN_AUDIT_H

#include <string>

#include "screen/score.h"

namespace physmas::screen {

// Audits the accepted candidate: the video exists, decodes to exactly T frames, and a multi-object candidate bonds no
// interface. Fills the audit of `record`; a failed check turns its decision into fail.
// video: path of the candidate's video, empty when none was rendered.
void audit_accepted(ScreenRecord& record, const Executed& executed, const SceneRecords& scene,
                    const std::string& video);

}  // namespace physmas::screen

#endif
