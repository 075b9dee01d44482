#include "bundle/selection.h"

#include <fmt/format.h>

#include "base/error.h"
#include "bundle/dense_component.h"
#include "bundle/view_rig.h"

namespace physmas::bundle {
namespace {

constexpr double kWorthAWarning = 1.25;

}  // namespace

Eigen::AlignedBox3d crop_box(const std::vector<double>& bounds, const std::string& option) {
  if (bounds.size() != 6) {
    throw Error(ExitCode::usage,
                fmt::format("{}: found {} numbers, expected x0 x1 y0 y1 z0 z1", option, bounds.size()));
  }
  Eigen::AlignedBox3d box;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(bounds[2 * axis] < bounds[2 * axis + 1])) {
      throw Error(ExitCode::usage, fmt::format("{}: found {} to {} along {}, expected the lower end first", option,
                                               bounds[2 * axis], bounds[2 * axis + 1], "xyz"[axis]));
    }
    box.min()[axis] = bounds[2 * axis];
    box.max()[axis] = bounds[2 * axis + 1];
  }
  return box;
}

size_t select_gaussians(Gaussians& g, const Selection& selection, const std::string& file) {
  const size_t before = g.size(), coefficients = sh_coefficient_count(g.sh_degree);
  const auto stays = [&](size_t i) {
    if (selection.opacity_threshold > 0 && !(g.opacity(i) > selection.opacity_threshold)) return false;
    if (!selection.crop) return true;
    const Eigen::Array3d p = (selection.crop_axes * g.position[i].cast<double>()).array();
    return (p > selection.crop->min().array()).all() && (p < selection.crop->max().array()).all();
  };
  size_t kept = 0;
  for (size_t i = 0; i < before; ++i) {
    if (!stays(i)) continue;
    if (kept != i) {
      g.position[kept] = g.position[i];
      g.log_scale[kept] = g.log_scale[i];
      g.rotation[kept] = g.rotation[i];
      g.opacity_logit[kept] = g.opacity_logit[i];
      for (size_t k = 0; k < coefficients; ++k) g.sh[kept * coefficients + k] = g.sh[i * coefficients + k];
    }
    ++kept;
  }
  if (kept == 0) {
    throw invalid_input({file, "",
                         fmt::format("none of {} Gaussians above the opacity threshold and inside the crop "
                                     "box",
                                     before),
                         "at least one", "pm-scene info shows the bounds and the opacities"});
  }
  g.resize(kept, g.sh_degree);
  return before - kept;
}

Floaters find_floaters(const Gaussians& gaussians) {
  Floaters floaters;
  floaters.box = robust_box_of(gaussians);
  Eigen::AlignedBox3d all;
  for (const Eigen::Vector3f& p : gaussians.position) {
    all.extend(p.cast<double>());
    floaters.count += !floaters.box.contains(p.cast<double>());
  }
  const double robust = floaters.box.sizes().maxCoeff();
  if (robust > 0) floaters.ratio = all.sizes().maxCoeff() / robust;
  return floaters;
}

std::string floater_warning(const Floaters& floaters, const Eigen::Vector3d& offset) {
  if (!(floaters.ratio > kWorthAWarning)) return "";
  return fmt::format(
      "{} floaters make the scene's box {:.3g} times as long: the object gets so much smaller in the "
      "solver; --crop {} removes them",
      floaters.count, floaters.ratio, crop_text(Eigen::AlignedBox3d(floaters.box).translate(offset)));
}

}  // namespace physmas::bundle
