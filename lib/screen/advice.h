// What to try when a gate fails: one sentence each, the same in records, in --explain and in docs/rejected.md.
#ifndef PHYSMAS_SCREEN_ADVICE_H
#define PHYSMAS_SCREEN_ADVICE_H

#include <array>
#include <string>

#include "records/execution.h"

namespace physmas::screen {

struct Advice {
  const char* gate;  // or "score", of a candidate that passes all gates
  const char* text;
};
inline constexpr std::array<Advice, 9> kAdvice = {{
    {"plan", "An action names something that is not there: correct the names in plan.json, or the PROMPT."},
    {"process",
     "The simulation was killed, mostly for want of memory: try SET=\"particles.max=50000 grid.n=48\", or run "
     "pm-simulate by hand to see its error."},
    {"numerical",
     "The simulation diverged: try SET=\"time.rule=cfl\", which takes steps as short as stability asks, a gentler "
     "action in the PROMPT, or a softer material."},
    {"spread",
     "It runs out, bursts or flies apart: ask for a gentler action in the PROMPT (\"gently\", \"at 0.2 m/s\"), try a "
     "smaller DROP=, or give it a stiffer or more cohesive material."},
    {"flattening",
     "It collapses or melts: give it a stiffer material, or ask for a gentler action in the PROMPT (\"gently\", \"at "
     "0.2 "
     "m/s\"); if it shall end flat, the best video is what you asked for."},
    {"support",
     "A part that counts as a support is soft: give it a hard expected label in the INVENTORY= (Wood, Metal, Ceramic), "
     "or a name without a word for supports if it is none."},
    {"achieved",
     "An action reached less than the run asks for: the record of the simulation says why and what to change (shortfall "
     "in rollouts/ID.json); ask for less in the PROMPT, or lower screening.achieved_min."},
    {"stillness",
     "What nothing moved drifted: try SET=\"time.start=equilibrium\" so that it carries its weight from the first step "
     "on, or give it a stiffer material."},
    {"score",
     "All gates passed, but Q is below tau: try SET=\"screening.tau=0.6\", which screens again without simulating "
     "anything, or name the parts' materials."},
}};

// The sentence for a failed gate of an executed candidate: of a diverged one what its execution record says.
std::string advice_for(const std::string& gate, const ExecutionRecord& execution);

// The table, one line per gate: its name, a tab, the sentence.
std::string advice_table();

}  // namespace physmas::screen

#endif
