// pm-material: row-wise material evidence from the inventory, the masks and, when given, a predictor's records.
#include "base/command_line.h"
#include "base/error.h"
#include "base/log.h"
#include "material/evidence.h"
#include "records/state.h"
#include "scene/scene.h"

using namespace physmas;

namespace {

struct Options {
  std::string scene, inventory, masks, state, out;
  std::string agent = "builtin";
  std::string predictor = "none";
};

bool is_remote(const std::string& name) {
  return name.find("://") != std::string::npos || name.rfind("replay:", 0) == 0;
}

int work(const Options& options) {
  if (options.agent != "builtin") {
    throw Error(ExitCode::usage,
                "--agent " + one_line(options.agent) + ": remote material agents are not built yet, expected builtin");
  }
  if (is_remote(options.predictor)) {
    throw Error(ExitCode::usage, "--predictor " + one_line(options.predictor) +
                                     ": remote predictors are not built yet, expected none or a file of records");
  }
  Provenance provenance;
  provenance.tool = "pm-material";
  provenance.options = {{"agent", options.agent}};
  for (const std::string& input : {options.scene, options.inventory, options.masks, options.state})
    provenance.add_input(input);

  SceneNeeds needs;
  needs.views = true;
  const Scene scene = load_scene(options.scene, needs);
  const Inventory inventory = load_inventory(options.inventory);
  std::vector<std::string> view_names;
  for (const SceneView& view : scene.views) view_names.push_back(view.name);
  const std::vector<ViewMasks> masks = load_masks(options.masks, inventory, view_names);
  const State state = load_state(options.state, &inventory);
  std::optional<MaterialRecords> records;
  if (options.predictor != "none") {
    provenance.add_input(options.predictor);
    records = load_material_records(options.predictor, inventory);
  }

  const Evidence evidence = material::reason_about_materials(inventory, state.gaussians_per_row(),
                                                             material::mask_confidences(inventory, masks), records);
  for (const EvidenceRow& row : evidence.rows) {
    log_info(row.key + ": " + kLabels[row.label].name + ", P " + std::to_string(row.confidence));
  }
  save_evidence(options.out, evidence, provenance);
  return static_cast<int>(ExitCode::done);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ToolMain tool;
  tool.name = "pm-material";
  tool.description = "Material evidence per object-part row: label posterior, guards, E and nu statistics.";
  tool.footer =
      "Example: pm-material --scene scene.json --inventory inventory.json --masks masks.h5 --state state.h5 "
      "--out evidence.json\n"
      "Reads physmas/scene, inventory, masks, state and, with --predictor FILE, physmas/material_records; writes "
      "physmas/evidence.\n"
      "The confidence of a row's mask is the mean over the views whose mask is not empty, 0 (unavailable) without any.";
  tool.options = [&](CLI::App& app) {
    app.add_option("--scene", options.scene, "scene.json or its slice")->required()->type_name("FILE");
    app.add_option("--inventory", options.inventory, "inventory.json")->required()->type_name("FILE");
    app.add_option("--masks", options.masks, "masks.h5")->required()->type_name("FILE");
    app.add_option("--state", options.state, "state.h5")->required()->type_name("FILE");
    app.add_option("--out", options.out, "evidence.json to write")->required()->type_name("FILE");
    app.add_option("--agent", options.agent, "Who reasons about materials: builtin")
        ->capture_default_str()
        ->type_name("NAME");
    app.add_option("--predictor", options.predictor,
                   "Crop, vision-language and authored records: none, or a file (physmas/material_records)")
        ->capture_default_str()
        ->type_name("none|FILE");
  };
  tool.work = [&](const CommonOptions&) { return work(options); };
  return run_tool(argc, argv, tool);
}
