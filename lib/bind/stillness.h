// Whether what nobody asked to move stood still, measured on the frames that the solver hands out.
#ifndef PHYSMAS_BIND_STILLNESS_H
#define PHYSMAS_BIND_STILLNESS_H

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mpm/simulation.h"
#include "records/candidate.h"
#include "records/execution.h"

namespace physmas::bind {

// Rows are still by right when no action acts on them, when they stand on something at rest (an obstacle, the wall that
// gravity pulls to, a row that stands; without gravity all do), and when nothing that moves by right came near them.
// Near is within two cells between bounding boxes, at any frame: that errs towards "touched", so what is measured is
// surely meant to stand still. The inventory's scene may well be made to move by gravity alone: then this says how much
// it did.
class StillnessMeter {
 public:
  // problem: what bind_problem makes of the candidate; read during this call only.
  StillnessMeter(const Candidate& candidate, const mpm::Problem& problem);

  // Every frame of the run, from frame 0 on.
  void observe(const mpm::Frame& frame);

  // At the last frame observed; none when no row is still by right.
  std::optional<Stillness> result() const;

 private:
  struct Box {
    mpm::Vec3d low, high;
  };
  struct Row {
    std::string key;
    std::vector<int> particles;
    std::vector<mpm::Vec3d> rest;
    bool moves = false;   // by right
    bool stands = false;  // at rest
    double drift = 0;     // m
  };
  std::vector<Box> boxes(const mpm::Frame& frame) const;
  void spread(const std::vector<Box>& boxes, bool Row::*quality);

  std::vector<Row> rows_;  // that have particles
  double near_, longest_side_;
};

}  // namespace physmas::bind

#endif
