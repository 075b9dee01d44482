// Records that keep every field: all values differ from one another and from the defaults, and each must be in the file
// and come back.
#include <doctest/doctest.h>

#include <functional>

#include "base/file.h"
#include "records/execution.h"
#include "records/hdf5_file.h"
#include "records/inventory.h"
#include "records/render.h"
#include "records/rollout.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

namespace {

Provenance test_provenance() {
  Provenance provenance;
  provenance.tool = "test";
  return provenance;
}

// Saves with `save`, which names the file, and again what `save_again` has loaded from it: the bytes must be equal and
// hold every text.
void check_kept(const std::function<void(const std::string&)>& save,
                const std::function<void(const std::string&)>& save_again, const std::vector<std::string>& texts) {
  const TemporaryFolder folder;
  const std::string path = folder / "record.json";
  save(path);
  const std::string bytes = read_file(path);
  for (const std::string& text : texts) {
    CAPTURE(text);
    CHECK(bytes.find(text) != std::string::npos);
  }
  save_again(path);
  CHECK(read_file(path) == bytes);
}

}  // namespace

TEST_CASE("records: an execution keeps every field") {
  ExecutionRecord r;
  r.candidate = "soft";
  r.exit = 101, r.signal = 102;
  r.diverged = true;
  r.error_tokens = {"speed", "nan"};
  r.reason = "it flew apart";
  r.first_bad_step = 103;
  r.max_speed = 104.5;
  r.J_min = 0.105, r.J_max = 1.065;
  r.mass = 107.5;
  r.momentum_start = {108.5, 109.5, 110.5}, r.momentum_end = {111.5, 112.5, 113.5};
  r.kinetic = {114.5, 115.5}, r.elastic = {116.5, 117.5}, r.potential = {118.5, 119.5};
  r.energy_measured = "steps";
  r.energy_residual = 120.5, r.energy_scale = 121.5, r.largest_step_residual = 122.5;
  double value = 136.5;
  for (const char* term :
       {"change", "transfer", "contact", "plastic", "viscous", "projection", "control", "structure", "residual"}) {
    r.energy_terms.push_back({term, {value, value + 1}});
    value += 2;
  }
  r.particles_outside = 127;
  r.step_rule = "cfl";
  r.substeps_per_frame = 128;
  r.steps = 129;
  r.dt = 0.125, r.smallest_dt = 0.0625, r.largest_dt = 0.25;
  r.retries = 130, r.discarded_steps = 131;
  r.frames = 132;
  AchievedAction action;
  action.type = ActionType::torque;
  action.rows = {"guitar/neck"};
  action.quantity = "angle", action.unit = "rad";
  action.requested = 155.5, action.achieved = 156.5, action.share = 0.157;
  action.shortfall = "too stiff";
  r.achieved = {action};
  r.stillness = Stillness{{"guitar/stand"}, 158.5, 0.159};
  r.particles = 133;
  r.grid = {{"n", 134}};
  r.precision = "double";
  r.deformation = "total";
  r.omitted = {{"a step", "no time"}};
  r.runtime = {{"threads", 135}};
  r.start = StartRecord{201, 202, 203, 204, 205, 0.206, 207.5, {{"vase/lip", 208}}};
  check_kept(
      [&](const std::string& path) { save_execution(path, r, test_provenance()); },
      [](const std::string& path) { save_execution(path, load_execution(path), test_provenance()); },
      {"soft",      "101",          "102",      "diverged",    "speed", "it flew apart", "103",    "104.5", "0.105",
       "1.065",     "107.5",        "108.5",    "109.5",       "110.5", "111.5",         "112.5",  "113.5", "114.5",
       "115.5",     "116.5",        "117.5",    "118.5",       "119.5", "steps",         "120.5",  "121.5", "122.5",
       "136.5",     "145.5",        "153.5",    "127",         "cfl",   "128",           "129",    "0.125", "0.0625",
       "0.25",      "130",          "131",      "132",         "133",   "134",           "double", "total", "a step",
       "no time",   "135",          "torque",   "guitar/neck", "angle", "\"rad\"",       "155.5",  "156.5", "0.157",
       "too stiff", "guitar/stand", "158.5",    "0.159",       "201",   "202",           "203",    "204",   "205",
       "0.206",     "207.5",        "vase/lip", "208"});
}

TEST_CASE("records: a rendering keeps every field") {
  RenderRecord r;
  r.candidate = "soft";
  r.video = "soft.mp4";
  r.frames_written = 101;
  r.file_size = 102;
  r.fps = 103.5;
  r.width = 104, r.height = 105;
  r.frames = {{106, true, 107, 108, 117, 128, 0.109}, {110, false, 0, 0, 0, 0, 0}};
  r.skipped_gaussians = 111;
  r.depth_unit = 0.112;
  r.omitted = {{"a frame", "no light"}};
  r.runtime = {{"threads", 113}};
  check_kept([&](const std::string& path) { save_render(path, r, test_provenance()); },
             [](const std::string& path) { save_render(path, load_render(path), test_provenance()); },
             {"soft", "soft.mp4", "101", "102", "103.5", "104", "105", "106", "107", "108", "117", "128", "0.109",
              "110", "111", "0.112", "a frame", "no light", "113"});
}

TEST_CASE("records: an inventory keeps every field") {
  Inventory inventory;
  inventory.objects = {{"cake", "a cake", "target of all", {{"front", "a layered cake"}}, {}}};
  inventory.objects[0].hints.colors = {{0.125, 0.25, 0.375}};
  inventory.objects[0].hints.tolerance = 0.0625;
  InventoryRow row;
  row.object = "cake";
  row.part = "plate";
  row.name = "a plate";
  row.structural_role = "bears the rest";
  row.physics_group = "rigid china";
  row.expected_labels = {"Ceramic", "Glass"};
  row.evidence_refs = {"photo 7"};
  row.hints.regions["back"] = {{{0.5, 0.625}, {0.75, 0.875}, {0.9375, 1}}};
  inventory.rows = {row, row};
  inventory.rows[1].part = "residual";
  inventory.rows[1].residual = true;
  const std::vector<Omission> omitted = {{"a candle", "nobody lit it"}};
  check_kept([&](const std::string& path) { save_inventory(path, inventory, omitted, test_provenance()); },
             [&](const std::string& path) { save_inventory(path, load_inventory(path), omitted, test_provenance()); },
             {"a cake", "target of all", "a layered cake", "0.375", "0.0625", "a plate", "bears the rest",
              "rigid china", "Ceramic", "Glass", "photo 7", "0.9375", "a candle", "nobody lit it"});
}

TEST_CASE("records: every series of a rollout must have the shape that the Gaussians ask for") {
  const TemporaryFolder folder;
  const std::vector<float> zeros(64, 0);
  const auto refusal = [&](uint64_t position, uint64_t F, uint64_t velocity) {
    Hdf5Writer out(folder / "r.h5", "rollout", test_provenance());
    const std::pair<const char*, uint64_t> series[] = {
        {"/frames/position", position}, {"/frames/F", F}, {"/frames/velocity", velocity}};
    for (const auto& [name, width] : series) {
      out.create_series(name, {2, width});
      out.append_slab(name, zeros.data());
    }
    out.write_float("/frames/time", {1}, zeros.data());
    out.commit();
    return message_of([&] { RolloutReader(folder / "r.h5", 2); });
  };
  CHECK(refusal(3, 9, 3) == "no error");
  CHECK(refusal(2, 9, 3).find("/frames/position") != std::string::npos);
  CHECK(refusal(3, 6, 3).find("/frames/F") != std::string::npos);
  CHECK(refusal(3, 9, 4).find("/frames/velocity") != std::string::npos);
}
