// The detector and the segmenter behind the Open Inference Protocol (docs/providers.md has their tensors).
#ifndef PHYSMAS_MASKS_MASK_MODELS_H
#define PHYSMAS_MASKS_MASK_MODELS_H

#include <map>
#include <string>
#include <vector>

#include "records/masks.h"
#include "remote/inference.h"

namespace physmas::masks {

// One thing that a detector found: a box in pixels, corners (x0, y0) and (x1, y1), inside the image.
struct Detection {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double score = 0;  // 0..1
  std::string phrase;
};

// The fixed configuration (paper, "Perception Configuration", names the models without printing it; these are
// Grounded-SAM's usual values).
constexpr double kBoxThreshold = 0.30;      // smallest score of a detection
constexpr double kOverlapThreshold = 0.80;  // of two boxes with a larger intersection over union the weaker is dropped
constexpr size_t kMaxBoxes = 16;            // per text and view, the strongest

// The detections of a reply: boxes [N, 4], scores [N], phrases [N]; cut to the image of width x height, filtered by the
// constants above, strongest first, ties in the server's order. A score outside 0..1, a box that is not finite or has
// its corners exchanged is an Error (exit code 4). source: for messages.
std::vector<Detection> detections_from(const std::map<std::string, remote::Tensor>& tensors, int width, int height,
                                       const std::string& source);

// The masks of a reply: masks [N, height, width], inside above 0.5, and scores [N]; confidence is the segmenter's
// score times the box's, source "models". Masks without a pixel are empty. Errors as above.
std::vector<Mask> masks_from(const std::map<std::string, remote::Tensor>& tensors, const std::vector<Detection>& boxes,
                             int width, int height, const std::string& source);

class MaskModels {
 public:
  // The backends must outlive the models. Asks both whether they are ready and have the contract's tensors.
  MaskModels(remote::Backend& detector, remote::Backend& segmenter,
             remote::TensorForm form = remote::TensorForm::automatic);

  // A mask for everything in one picture that fits `text`, strongest box first; empty when there is nothing.
  // name: of the exchanges, unique. Errors: exit code 4.
  std::vector<Mask> find(const std::string& name, const std::string& png, const std::string& text, int width,
                         int height);

 private:
  remote::InferenceClient detector_, segmenter_;
};

}  // namespace physmas::masks

#endif
