// Support that masks give to pixels: the evidence functions of the paper's Eqs. (objectscore) and (partscore).
#ifndef PHYSMAS_LIFT_EVIDENCE_H
#define PHYSMAS_LIFT_EVIDENCE_H

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "records/masks.h"

namespace physmas::lift {

// The frozen settings of the paper's Table "lifting-settings"; the floor of a mask's confidence is in records/masks.h.
constexpr double kSupportLow = 0.45, kSupportHigh = 1.00;  // interior-distance support
constexpr double kResidualConfidenceCap = 0.20;
constexpr double kAreaTieBreak = 1e-6;  // over max(1, A_r)
constexpr double kAmbiguousMargin = 0.18, kReliableMargin = 0.30;
constexpr int kObjectNeighbors = 12, kPartNeighbors = 16;
constexpr long kRescueLeast = 64;
constexpr double kRescueShare = 0.003;  // of N_G

// e_v(u) of one mask by pixel, [H * W] by rows: confidence (floored) times 0.45 + 0.55 d/d_max inside, 0 outside; d is
// the exact Euclidean distance from the pixel to the nearest pixel outside the mask, d_max its maximum in this mask.
// Beyond the image is no boundary: an object that the image cuts off is not near its edge there. A mask that covers
// the whole image has no boundary and locates nothing: 0.45 everywhere, so that every other mask wins inside itself.
// Empty where the mask is empty.
std::vector<float> support_of(const Mask& mask);

}  // namespace physmas::lift

#endif
