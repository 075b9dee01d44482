// A rollout as a compact stream that a page plays: the rest state once, then what moved, frame by frame.
#ifndef PHYSMAS_REPORT_STREAM_H
#define PHYSMAS_REPORT_STREAM_H

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "scene/gaussians.h"
#include "splat/rollout_frames.h"

namespace physmas::report {

// How much a stream may hold; beyond that it takes every second, third, ... frame, and the Gaussians that cover most.
struct StreamLimits {
  size_t gaussians = 300000;
  size_t gaussian_frames = 12000000;  // Gaussians times frames: what a page keeps in memory, 24 bytes each
  size_t bytes = 0;                   // of the packed stream; 0: any number
};

// Steps of the quantised values. A value is off by half a step at most, in every frame: frames do not add up their
// errors. Values beyond the range of 16 bits are cut there, and counted.
struct StreamSteps {
  double position = 0;     // of displacements, scene units: a 8192nd of the scene's diagonal at rest
  double deformation = 0;  // of the entries of F - I
  double rest = 0;         // of rest means, scene units
  double log_scale = 0, rotation = 0, opacity = 0, color = 0;
  double harmonics = 0;  // of the coefficients beyond the first: 127 steps hold the largest
};

// `bytes` is a row of chunks, each deflated by itself (zlib's format, RFC 1950): the rest state, then one per frame.
// A chunk is a row of planes, one per component, each with a value per Gaussian: a byte for the prediction, a byte for
// the width w, then w times N bytes, the lowest bytes of all values first. Values are whole numbers of steps, minus
// their prediction, zigzag coded (0, -1, 1, -2, ...). Prediction: bits 0 and 1 are how many earlier frames it uses, 1:
// the value of the frame before, 2: the line through the two before; bit 2: what remains is stored as its difference
// from that of the Gaussian before. The components of a frame are three displacements and the nine entries of F - I by
// rows; an F of which the first entry is kHidden belongs to a Gaussian that is not shown.
struct Stream {
  static constexpr int kComponents = 12;
  static constexpr int kHidden = -32768;
  std::vector<size_t> kept;  // [N] Gaussians of the scene, in the stream's order: by row, near ones together
  std::vector<int> frames;   // [T] of the rollout
  int sh_degree = 0;
  StreamSteps steps;
  Eigen::Vector3d origin;           // of rest means, scene space
  std::vector<size_t> chunk_bytes;  // [1 + T]
  std::string bytes;
  long cut = 0;     // values beyond their range
  long hidden = 0;  // Gaussians, over all frames, that were not finite
};

// row: [N_G]; sh_degree: at most as many degrees of the harmonics. `frame(t)` is frame t of `frame_count`, at least
// one. The same input gives the same bytes, whatever the number of threads.
Stream make_stream(const Gaussians& gaussians, const std::vector<int32_t>& row, int sh_degree, int frame_count,
                   const std::function<splat::TransportedFrame(int)>& frame, const StreamLimits& limits = {});

}  // namespace physmas::report

#endif
