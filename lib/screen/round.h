// A round of the screen on files: what was executed is loaded, decided, audited and written.
#ifndef PHYSMAS_SCREEN_ROUND_H
#define PHYSMAS_SCREEN_ROUND_H

#include <string>
#include <vector>

#include "records/provenance.h"
#include "records/screen.h"
#include "screen/score.h"

namespace physmas::screen {

// Paths of files, and of the folders that hold a record per candidate.
struct RoundFiles {
  std::string scene, plan, evidence, inventory;
  std::string candidates, rollouts, videos;  // folders
  std::string out;                           // the screen record to write
  std::string accepted, final_video;         // written on acceptance, removed otherwise; empty: not asked for
};

// Every candidate of rounds 0..round with its execution and render record, first appearance first. Records that do not
// belong together, or an id that comes twice, are an Error (exit code 3). What was read is added to `provenance`.
std::vector<Executed> load_executed(const RoundFiles& files, int round, const Inventory& inventory,
                                    Provenance& provenance);

// Decides the round, writes its record and, beside it, the decision for make (a .mk file), and publishes or withdraws
// what was accepted. A round that the run specification does not allow is an Error (exit code 2).
ScreenRecord screen_round(const RoundFiles& files, int round);

}  // namespace physmas::screen

#endif
