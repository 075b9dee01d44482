// Two frames of a few balls, for tests of what the screen measures.
#ifndef PHYSMAS_TESTS_SPLAT_MOTION_H
#define PHYSMAS_TESTS_SPLAT_MOTION_H

#include <vector>

#include "splat/foreground.h"
#include "splat/own_frame.h"
#include "splat/quantize.h"
#include "unit/splat/scenes.h"
#include "unit/temporary_folder.h"

namespace physmas::splat_test {

using namespace splat;

// Opaque balls around the origin, all grey.
inline Gaussians balls(const std::vector<Eigen::Vector3f>& places, float grey = 0.6f) {
  Gaussians g = one_gaussian(0.1f, 0.95f, grey);
  g.position = places;
  g.rotation.resize(places.size(), g.rotation[0]);
  g.log_scale.resize(places.size(), g.log_scale[0]);
  g.opacity_logit.resize(places.size(), g.opacity_logit[0]);
  g.sh.resize(places.size(), g.sh[0]);
  return g;
}

constexpr int kWidth = 100, kHeight = 80;

// Two frames: at rest, and with every ball moved.
struct Motion {
  // deformed: F of every Gaussian in the last frame; empty for none.
  Motion(const Gaussians& g, const std::vector<Eigen::Vector3f>& moved,
         const std::vector<splat::RowMatrix3f>& deformed = {})
      : gaussians(g), renderer(gaussians) {
    scene.output_cameras = {front_camera(kWidth, kHeight)};
    scene.run.time.frames = 2;
    state.gaussian_row.assign(g.size(), 0);
    state.gaussian_object.assign(g.size(), 0);
    state.row_keys = {"thing/body"};
    Provenance provenance;
    provenance.tool = "test";
    RolloutWriter out(folder / "r.h5", g.size(), "elastic", provenance);
    for (int t = 0; t < 2; ++t) {
      std::vector<float> x, F, v(3 * g.size(), 0);
      for (size_t i = 0; i < g.size(); ++i) {
        const Eigen::Vector3f p = t == 0 ? g.position[i] : moved[i];
        x.insert(x.end(), p.data(), p.data() + 3);
        for (int k = 0; k < 9; ++k)
          F.push_back(t == 1 && !deformed.empty() ? deformed[i].data()[k] : k % 4 == 0 ? 1.0f : 0.0f);
      }
      out.append(0.04 * t, x.data(), F.data(), v.data());
    }
    out.commit();
  }
  // What the video's frame t shows.
  FrameForeground picture(int t) {
    const RolloutFrames rollout(folder / "r.h5", state);
    const TransportedFrame frame = rollout.frame(t);
    const RenderedImage& image = renderer.render(scene.output_camera(t), frame.deformation(), {});
    return measure_foreground(image, quantize(image), t, scene.run.screening.dark_luminance);
  }
  // What pm-render records of the pictures.
  RenderRecord record() {
    RenderRecord record;
    record.frames = {picture(0), picture(1)};
    const RolloutFrames rollout(folder / "r.h5", state);
    record.endpoints = measure_endpoints(renderer, gaussians, rollout, scene, {}, record.frames);
    record.own_frame = measure_own_frame(renderer, gaussians, rollout, scene, state, {}, record);
    return record;
  }
  std::vector<FrameForeground> endpoints() {
    const RolloutFrames rollout(folder / "r.h5", state);
    return measure_endpoints(renderer, gaussians, rollout, scene, {}, {picture(0), picture(1)});
  }

  TemporaryFolder folder;
  Gaussians gaussians;
  Renderer renderer;
  Scene scene;
  State state;  // the identity map
};

}  // namespace physmas::splat_test

#endif
