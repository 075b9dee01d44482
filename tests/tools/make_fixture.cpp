// Writes the binary and derived fixtures of the command-line tests: small, exact, and made with the library itself.
//   make_fixture masks INVENTORY OUT CONFIDENCE [W H]  four 4x3 views, every semantic row visible in front and right
//   make_fixture views SCENE                           the scene's view images, a gradient each
//   make_fixture state INVENTORY OUT COUNT...          COUNT Gaussians per row, no filled particles
//   make_fixture video OUT FRAMES                      a noisy 64x64 video of at least 4096 bytes
//   make_fixture execution CANDIDATE OUT [TOKEN]       an execution record of that very file, and beside it a
//                                                      file in the place of its rollout; TOKEN: it diverged
//   make_fixture render ID VIDEO OUT FRAMES X1 Y1      a render record; boxes 0 0 10 10 at first, 0 0 X1 Y1 at last
#include <cstdio>
#include <filesystem>
#include <random>

#include "base/error.h"
#include "base/file.h"
#include "records/candidate.h"
#include "records/execution.h"
#include "records/masks.h"
#include "records/render.h"
#include "records/scene.h"
#include "records/state.h"
#include "scene/image_file.h"
#include "splat/video.h"

using namespace physmas;

namespace {

using Arguments = std::vector<std::string>;

Provenance provenance_of(const Arguments& inputs) {
  Provenance provenance;
  provenance.tool = "make_fixture";
  for (const std::string& input : inputs) provenance.add_input(input);
  return provenance;
}

void make_masks(const Arguments& a) {
  const Inventory inventory = load_inventory(a.at(0));
  const int width = a.size() > 3 ? std::stoi(a.at(3)) : 4, height = a.size() > 3 ? std::stoi(a.at(4)) : 3;
  const Mask filled{width, height, std::vector<uint8_t>(size_t(width) * height, 255), std::stod(a.at(2)), "fixture"};
  std::vector<ViewMasks> views;
  for (const char* name : {"front", "right", "back", "left"}) {
    ViewMasks view{name, std::vector<Mask>(inventory.objects.size()), std::vector<Mask>(inventory.rows.size())};
    const bool visible = view.view == "front" || view.view == "right";
    for (size_t r = 0; visible && r < inventory.rows.size(); ++r) {
      if (!inventory.rows[r].residual) view.rows[r] = filled;
    }
    views.push_back(view);
  }
  save_masks(a.at(1), inventory, views, {}, provenance_of({a.at(0)}));
}

void make_views(const Arguments& a) {
  for (const SceneView& view : load_scene(a.at(0), {}).views) {
    Image image(view.camera.width, view.camera.height, 3);
    for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<uint8_t>(5 * i + view.name.size());
    save_png(view.image, image);
  }
}

void make_state(const Arguments& a) {
  const Inventory inventory = load_inventory(a.at(0));
  State state;
  state.row_keys = inventory.row_keys();
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    for (long i = 0; i < std::stol(a.at(2 + r)); ++i) {
      const int32_t index = static_cast<int32_t>(state.gaussian_row.size());
      state.gaussian_object.push_back(inventory.object_of_row(static_cast<int>(r)));
      state.gaussian_row.push_back(static_cast<int32_t>(r));
      state.gaussian_confidence.push_back(1);
      state.position.emplace_back(1, 1, 0.5f + 0.01f * index);
      state.volume.push_back(1e-6f);
      state.source.push_back(index);
    }
  }
  state.row = state.gaussian_row;
  state.object = state.gaussian_object;
  save_state(a.at(1), state, provenance_of({a.at(0)}));
}

void make_video(const Arguments& a) {
  splat::VideoWriter writer(a.at(0), 64, 64, 25);
  std::mt19937 random(7);
  for (int t = 0; t < std::stoi(a.at(1)); ++t) {
    Image frame(64, 64, 3);
    for (uint8_t& value : frame.pixels) value = static_cast<uint8_t>(random());
    writer.write(frame);
  }
  writer.finish();
}

void make_execution(const Arguments& a) {
  const Candidate candidate = load_candidate(a.at(0));
  ExecutionRecord record;
  record.candidate = candidate.id;
  if (a.size() > 2) {
    record.diverged = true;
    record.error_tokens = {a[2]};
    record.first_bad_step = 12;
  }
  record.mass = 1;
  record.substeps_per_frame = candidate.timestep.substeps;
  record.dt = candidate.timestep.dt;
  record.frames = 3;
  record.particles = 1;
  const std::string rollout = std::filesystem::path(a.at(1)).replace_extension(".h5").string();
  write_file(rollout, "no rollout, of " + candidate.id);
  Provenance provenance = provenance_of({a.at(0)});
  provenance.add_output(rollout);
  save_execution(a.at(1), record, provenance);
}

void make_render(const Arguments& a) {
  RenderRecord record;
  record.candidate = a.at(0);
  record.video = std::filesystem::path(a.at(1)).filename().string();
  record.frames_written = std::stoi(a.at(3));
  record.file_size = static_cast<long>(std::filesystem::file_size(a.at(1)));
  record.width = record.height = 64;
  for (int t = 0; t < record.frames_written; ++t) {
    const bool last = t + 1 == record.frames_written;
    record.frames.push_back({t, true, 0, 0, last ? std::stoi(a.at(4)) : 10, last ? std::stoi(a.at(5)) : 10, 0.0});
  }
  save_render(a.at(2), record, provenance_of({}));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const Arguments arguments(argv + std::min(argc, 2), argv + argc);
  try {
    if (what == "masks") return make_masks(arguments), 0;
    if (what == "views") return make_views(arguments), 0;
    if (what == "state") return make_state(arguments), 0;
    if (what == "video") return make_video(arguments), 0;
    if (what == "execution") return make_execution(arguments), 0;
    if (what == "render") return make_render(arguments), 0;
    std::fprintf(stderr, "make_fixture: unknown fixture \"%s\"\n", what.c_str());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "make_fixture: %s\n", e.what());
  }
  return 1;
}
