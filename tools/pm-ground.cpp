// pm-ground: the scene agent. A prompt and four calibrated views in; inventory, plan and masks out.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "base/command_line.h"
#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "masks/perception.h"
#include "plan/action_proposal.h"
#include "plan/authored_plan.h"
#include "plan/chat_agent.h"
#include "plan/one_part.h"
#include "plan/scene_geometry.h"
#include "plan/scene_inventory.h"
#include "plan/scene_plan.h"
#include "plan/stated_materials.h"
#include "records/inventory.h"
#include "records/json.h"
#include "records/known_names.h"
#include "records/masks.h"
#include "records/plan.h"
#include "records/scene.h"
#include "remote/address.h"
#include "remote/check.h"
#include "remote/request_files.h"

using namespace physmas;
using remote::BackendKind;

namespace {

struct Options {
  std::string scene, out, model, agent = "builtin", perception = "builtin";
  std::string material, plan;
  std::string detector = "grounding-dino", segmenter = "sam2";
  remote::RemoteOptions remote;
};

const std::string kMasks = "masks:";

bool names_masks(const std::string& perception) {
  return perception.rfind(kMasks, 0) == 0 && perception.size() > kMasks.size();
}

// The address of model `name`: below the given path, or below /v2/models.
std::unique_ptr<remote::Backend> open_model(const Options& options, const std::string& name) {
  if (remote::backend_kind(options.perception, {}) == BackendKind::recorded)
    return remote::open_backend(options.perception, "--perception", "", options.remote);
  const remote::Url url = remote::parse_url(options.perception, "--perception");
  const std::string path = url.path.empty() ? "/v2/models" : url.path;
  return remote::open_backend(url.origin + path + "/" + name + url.query, "--perception", "", options.remote);
}

// The models that the flags name, opened before anything is asked: a wrong flag should not cost an answer.
class Models {
 public:
  explicit Models(const Options& options) {
    const BackendKind agent = remote::backend_kind(options.agent, {"builtin"});
    const BackendKind perception = remote::backend_kind(options.perception, {"builtin"});
    if (agent == BackendKind::file)
      throw Error(ExitCode::usage, "--agent " + one_line(options.agent) + ": expected builtin, a URL, or replay:DIR");
    if (perception == BackendKind::file && !names_masks(options.perception)) {
      throw Error(ExitCode::usage, "--perception " + one_line(options.perception) +
                                       ": expected builtin, masks:DIR, a URL, or replay:DIR");
    }
    if (!options.remote.body.empty() && agent == BackendKind::builtin)
      throw Error(ExitCode::usage, "--body has fields of a chat request, expected --agent URL with it");
    if (agent != BackendKind::builtin) {
      agent_ = remote::open_backend(options.agent, "--agent", "/v1", options.remote);
      chat.emplace(*agent_, options.model, remote::load_body_fields(options.remote.body));
    }
    if (perception == BackendKind::remote || perception == BackendKind::recorded) {
      form_ = remote::tensor_form(options.remote.tensors);
      detector_ = open_model(options, options.detector);
      segmenter_ = open_model(options, options.segmenter);
    }
  }

  // Empty where the built-in agent or perception, or mask files, are asked for.
  std::optional<remote::ChatClient> chat;
  bool has_perception() const { return detector_ != nullptr; }
  // Asks both models whether they are ready.
  masks::MaskModels perception() const { return {*detector_, *segmenter_, form_}; }

  std::vector<ExchangeReference> exchanges() const {
    std::vector<ExchangeReference> all;
    for (const remote::Backend* backend : {agent_.get(), detector_.get(), segmenter_.get()}) {
      if (backend != nullptr) all.insert(all.end(), backend->exchanges().begin(), backend->exchanges().end());
    }
    return all;
  }

 private:
  std::unique_ptr<remote::Backend> agent_, detector_, segmenter_;
  remote::TensorForm form_ = remote::TensorForm::automatic;
};

int ground_scene(Options options) {
  if (options.remote.exchanges.empty())
    options.remote.exchanges = (std::filesystem::path(options.out) / "exchanges").string();
  Models models(options);
  const Scene scene = load_scene(options.scene, {true, models.has_perception(), true, false});
  std::vector<std::string> view_names;
  for (const SceneView& view : scene.views) view_names.push_back(view.name);
  std::optional<masks::MaskModels> mask_models;
  if (models.has_perception()) mask_models.emplace(models.perception());

  std::vector<ViewPicture> pictures;
  if (models.chat || mask_models) pictures = load_view_pictures(scene);
  std::optional<plan::ChatAgent> agent;
  std::optional<Inventory> registered;
  if (!scene.inventory.empty()) {
    registered = load_inventory(scene.inventory);
    require_known_names(*registered, view_names, scene.inventory);
  }
  Inventory inventory;
  Json proposal;
  if (models.chat) {
    agent.emplace(*models.chat, scene, pictures);
    proposal = agent->propose(registered ? &*registered : nullptr, inventory);
  } else {
    inventory = registered ? *registered : plan::inventory_from_prompt(scene.prompt, scene.name);
  }
  plan::complete_inventory(inventory, view_names, scene.inventory);

  masks::MaskSource source;
  if (names_masks(options.perception)) source.folder = options.perception.substr(kMasks.size());
  if (options.perception == "builtin") source.folder = scene.masks;
  source.models = mask_models ? &*mask_models : nullptr;
  if (agent) {
    source.planner = [&](Inventory& asked, const std::vector<std::string>& missed, const Queries& tried) {
      return agent->plan_perception(asked, missed, tried);
    };
  }
  masks::Perception perception = masks::perceive(scene, inventory, pictures, source);
  const plan::SceneGeometry geometry = plan::measure_scene(scene, inventory, perception.views);
  Plan plan = !options.plan.empty() ? plan::authored_plan(options.plan, scene.prompt, inventory)
              : agent               ? plan::compile_proposal(proposal, scene.prompt, inventory, geometry, scene.run)
                                    : plan::plan_from_prompt(scene.prompt, inventory, geometry, scene.run, scene.file);
  for (const PlanMaterial& material : plan::stated_materials(options.material, inventory))
    plan.materials.push_back(material);
  plan::expect_materials(plan.materials, inventory);
  if (!scene.run.ablation.object_part_state) plan::collapse_parts(inventory, perception.views, plan);

  Provenance provenance;
  provenance.tool = "pm-ground";
  provenance.options = {{"agent", agent ? "chat model" : "builtin"},
                        {"perception", mask_models              ? "detector and segmenter"
                                       : !source.folder.empty() ? "masks"
                                                                : "builtin"}};
  provenance.add_input(options.scene);
  if (!scene.inventory.empty()) provenance.add_input(scene.inventory);
  if (!options.plan.empty()) provenance.add_input(options.plan);
  for (const std::string& file : perception.files) provenance.add_input(file);
  const std::filesystem::path out = options.out;
  const std::vector<Omission> rejected = agent ? agent->rejected() : std::vector<Omission>();
  const std::string inventory_path = (out / "inventory.json").string(), masks_path = (out / "masks.h5").string();
  save_masks(masks_path, inventory, perception.views, perception.omitted, provenance);
  Provenance with_masks = provenance;
  with_masks.add_output(masks_path);
  save_inventory(inventory_path, inventory, rejected, with_masks, models.exchanges());
  provenance.add_input(inventory_path);
  save_plan((out / "plan.json").string(), plan, provenance);
  for (const Omission& omission : rejected) log_info(omission.what + ": " + omission.why);
  for (const Omission& omission : perception.omitted) log_info(omission.what + ": " + omission.why);
  for (const std::string& correction : plan.corrections) {
    // What was guessed or dropped decides what a user gets to see; what is not done, all the more.
    if (correction.rfind(plan::kNotUnderstood, 0) == 0 || correction.rfind(plan::kNotDone, 0) == 0) {
      log_warning("the prompt: " + correction);
    } else {
      log_note("the prompt: " + correction);
    }
  }
  return static_cast<int>(ExitCode::done);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  remote::CheckOptions checking;
  // A server that is to be checked should say now what is wrong.
  checking.remote.retries = 0;
  checking.remote.budget = 600;
  Command check;
  ToolMain tool;
  tool.name = "pm-ground";
  tool.description = "Find the objects and parts of a scene in its four views, and make the prompt a plan of actions.";
  tool.footer =
      "Example: pm-ground --scene bundle/scene.json --out runs/cake\n"
      "         pm-ground --scene bundle/scene.json --out runs/cake --agent http://localhost:8000/v1 --model qwen3-vl\n"
      "         pm-ground check http://localhost:8000/v1 --model qwen3-vl\n"
      "Reads scene.json (or its slice), the views, an authored inventory, plan and masks; writes inventory.json, "
      "plan.json "
      "and masks.h5 into --out and, with a model server, exchanges/NAME.json (physmas/exchange).\n"
      "The key for a model server is read from the environment variable PM_API_KEY and written nowhere.";
  tool.options = [&](Command app) {
    app.add_option("--scene", options.scene, "Scene bundle, or its slice for this stage (required)");
    app.add_option("--out", options.out, "Folder for the three records (required)");
    app.add_option("--agent", options.agent,
                   "builtin (authored inventory, lexical plan), the URL of an OpenAI-compatible server "
                   "(http://localhost:8000/v1), or replay:DIR")
        .capture_default_str()
        .type_name("builtin|URL|replay:DIR");
    app.add_option("--material", options.material,
                   "What parts are made of: PART=LABEL ..., or LABEL for all; it becomes the expected label")
        .type_name("TEXT");
    app.add_option("--plan", options.plan,
                   "A plan (physmas/plan) whose actions are taken in place of those that the prompt gives")
        .type_name("FILE");
    app.add_option("--model", options.model, "Name of the chat model on that server").type_name("NAME");
    app.add_option("--perception", options.perception,
                   "builtin (the bundle's masks, else by appearance hints), masks:DIR (VIEW/OBJECT.png, "
                   "VIEW/OBJECT/PART.png, COCO JSON), the URL of an Open Inference Protocol server "
                   "(http://localhost:8001), or replay:DIR")
        .capture_default_str()
        .type_name("builtin|masks:DIR|URL|replay:DIR");
    app.add_option("--detector", options.detector, "Name of the detector on that server").capture_default_str();
    app.add_option("--segmenter", options.segmenter, "Name of the segmenter on that server").capture_default_str();
    remote::add_remote_options(app, options.remote);
    remote::add_chat_options(app, options.remote);
    remote::add_tensor_options(app, options.remote);

    check = app.add_subcommand("check", "Ask a model server what works with it, before anything is run");
    check
        .add_option("URL", checking.url,
                    "A chat server (http://localhost:8000/v1), an inference server, or one model of it "
                    "(http://localhost:8001/v2/models/predictor)")
        .required();
    check.add_option("--model", checking.model, "Name of the chat model; by default the first that the server names")
        .type_name("NAME");
    check.add_option("--detector", checking.detector, "Name of the detector on an inference server")
        .capture_default_str();
    check.add_option("--segmenter", checking.segmenter, "Name of the segmenter on it").capture_default_str();
    remote::add_remote_options(check, checking.remote);
    remote::add_chat_options(check, checking.remote);
    remote::add_tensor_options(check, checking.remote);
  };
  tool.work = [&](const CommonOptions&) {
    if (check.parsed())
      return static_cast<int>(remote::check_server(checking) ? ExitCode::done : ExitCode::provider_failed);
    if (options.scene.empty() || options.out.empty())
      throw Error(ExitCode::usage, (options.scene.empty() ? "--scene" : "--out") + std::string(" is required"));
    return ground_scene(options);
  };
  return run_tool(argc, argv, tool);
}
