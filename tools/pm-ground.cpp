// pm-ground: the scene agent. A prompt and four calibrated views in; inventory, plan and masks out.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "base/command_line.h"
#include "base/error.h"
#include "base/log.h"
#include "ground/one_part.h"
#include "ground/perception.h"
#include "ground/scene_geometry.h"
#include "ground/scene_inventory.h"
#include "ground/scene_plan.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/plan.h"
#include "scene/scene.h"

using namespace physmas;

namespace {

struct Options {
  std::string scene, out, agent = "builtin", perception = "builtin";
};

// The folder of "masks:DIR", the bundle's own masks, or nothing for the built-in segmenter.
std::string mask_folder(const Options& options, const Scene& scene) {
  if (options.agent != "builtin")
    throw Error(ExitCode::usage, "--agent " + options.agent + ": not built yet, expected builtin");
  if (options.perception.rfind("masks:", 0) == 0 && options.perception.size() > 6) return options.perception.substr(6);
  if (options.perception != "builtin")
    throw Error(ExitCode::usage,
                "--perception " + options.perception + ": not built yet, expected builtin or masks:DIR");
  return scene.masks;
}

int ground_scene(const Options& options) {
  const Scene scene = load_scene(options.scene, {true, false, true, false});
  const std::string folder = mask_folder(options, scene);
  std::vector<std::string> view_names;
  for (const SceneView& view : scene.views) view_names.push_back(view.name);
  Inventory inventory =
      scene.inventory.empty() ? ground::inventory_from_prompt(scene.prompt) : load_inventory(scene.inventory);
  ground::complete_inventory(inventory, view_names, scene.inventory);
  ground::Perception perception = ground::perceive(scene, inventory, folder);
  const ground::SceneGeometry geometry = ground::measure_scene(scene, inventory, perception.views);
  Plan plan = ground::plan_from_prompt(scene.prompt, inventory, geometry, scene.run, scene.file);
  if (!scene.run.ablation.object_part_state) ground::collapse_parts(inventory, perception.views, plan);

  Provenance provenance;
  provenance.tool = "pm-ground";
  provenance.options = {{"agent", options.agent}, {"perception", folder.empty() ? "builtin" : "masks"}};
  provenance.add_input(options.scene);
  if (!scene.inventory.empty()) provenance.add_input(scene.inventory);
  for (const std::string& file : perception.files) provenance.add_input(file);
  const std::filesystem::path out = options.out;
  save_inventory((out / "inventory.json").string(), inventory, {}, provenance);
  save_masks((out / "masks.h5").string(), inventory, perception.views, perception.omitted, provenance);
  save_plan((out / "plan.json").string(), plan, provenance);
  for (const Omission& omission : perception.omitted) log_info(omission.what + ": " + omission.why);
  for (const std::string& correction : plan.corrections) log_info(correction);
  return static_cast<int>(ExitCode::done);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ToolMain tool;
  tool.name = "pm-ground";
  tool.description = "Find the objects and parts of a scene in its four views, and make the prompt a plan of actions.";
  tool.footer =
      "Example: pm-ground --scene bundle/scene.json --out runs/cake\n"
      "Reads scene.json (or its slice), the views, an authored inventory and masks; writes inventory.json, plan.json "
      "and "
      "masks.h5 into --out.";
  tool.options = [&](CLI::App& app) {
    app.add_option("--scene", options.scene, "Scene bundle, or its slice for this stage")->required();
    app.add_option("--out", options.out, "Folder for the three records")->required();
    app.add_option("--agent", options.agent, "builtin: authored inventory, lexical plan")->capture_default_str();
    app.add_option("--perception", options.perception,
                   "builtin: the bundle's masks, else by appearance hints; masks:DIR: VIEW/OBJECT.png, "
                   "VIEW/OBJECT/PART.png")
        ->capture_default_str();
  };
  tool.work = [&](const CommonOptions&) { return ground_scene(options); };
  return run_tool(argc, argv, tool);
}
