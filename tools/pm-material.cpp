// pm-material: row-wise material evidence from the inventory, the masks and, when given, models and authored records.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "base/command_line.h"
#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "material/chat_source.h"
#include "material/evidence.h"
#include "material/field_evidence.h"
#include "material/predictor_source.h"
#include "records/state.h"
#include "remote/request_files.h"
#include "scene/view_pictures.h"

using namespace physmas;
using remote::BackendKind;

namespace {

struct Options {
  std::string scene, inventory, masks, state, out, authored, model;
  std::string agent = "builtin";
  std::string predictor = "none";
  remote::RemoteOptions remote;
};

// What the models and the authored files say; empty when there is none of them.
std::optional<MaterialRecords> observe(const Options& options, const Scene& scene, const Inventory& inventory,
                                       const std::vector<ViewMasks>& masks, Evidence& evidence,
                                       Provenance& provenance) {
  const BackendKind agent = remote::backend_kind(options.agent, {"builtin"});
  const BackendKind predictor = remote::backend_kind(options.predictor, {"none"});
  std::optional<MaterialRecords> records;
  const auto take = [&](const MaterialRecords& more) {
    if (!records) records.emplace();
    append_records(*records, more);
  };
  const auto keep_exchanges = [&](const remote::Backend& backend) {
    evidence.exchanges.insert(evidence.exchanges.end(), backend.exchanges().begin(), backend.exchanges().end());
  };
  std::optional<MaterialRecords> authored;
  if (!options.authored.empty()) authored = load_material_records(options.authored, inventory);
  // What is only stated leaves the observations as they are.
  if (!(authored && authored->has_observations()) && !scene.materials.empty()) {
    MaterialRecords came = load_material_records(scene.materials, inventory);
    share_with_only_row(came, inventory);
    provenance.add_input(scene.materials);
    take(came);
    log_note("materials as the imported configuration says; --authored FILE (AUTHORED=) replaces them");
  }
  if (authored) {
    provenance.add_input(options.authored);
    take(*authored);
  }
  if (predictor == BackendKind::file) {
    provenance.add_input(options.predictor);
    take(load_material_records(options.predictor, inventory));
  }
  if (agent == BackendKind::builtin && (predictor == BackendKind::builtin || predictor == BackendKind::file))
    return records;
  // Both are opened before anything is asked: a wrong flag should not cost an answer.
  std::unique_ptr<remote::Backend> predictor_backend, agent_backend;
  std::optional<remote::ChatClient> chat;
  if (predictor == BackendKind::remote || predictor == BackendKind::recorded)
    predictor_backend = remote::open_backend(options.predictor, "--predictor", "/v2/models/predictor", options.remote);
  if (agent != BackendKind::builtin) {
    agent_backend = remote::open_backend(options.agent, "--agent", "/v1", options.remote);
    chat.emplace(*agent_backend, options.model, remote::load_body_fields(options.remote.body));
  }
  const std::vector<ViewPicture> pictures = load_view_pictures(scene);
  if (predictor_backend) {
    remote::InferenceClient client(*predictor_backend, "predictor", remote::tensor_form(options.remote.tensors));
    take(material::predict_rows(client, inventory, pictures, masks));
    keep_exchanges(*predictor_backend);
  }
  if (chat) {
    take(material::ask_about_rows(*chat, inventory, pictures, masks, evidence.omitted));
    keep_exchanges(*agent_backend);
  }
  return records;
}

// The same for a server and for its recorded exchanges, so that a replay gives the same bytes.
std::string option_text(const std::string& text, const std::vector<std::string>& words, const char* model) {
  switch (remote::backend_kind(text, words)) {
    case BackendKind::builtin:
      return text;
    case BackendKind::file:
      return "file";
    default:
      return model;
  }
}

int work(Options options) {
  if (remote::backend_kind(options.agent, {"builtin"}) == BackendKind::file)
    throw Error(ExitCode::usage, "--agent " + one_line(options.agent) + ": expected builtin, a URL, or replay:DIR");
  if (!options.remote.body.empty() && remote::backend_kind(options.agent, {"builtin"}) == BackendKind::builtin)
    throw Error(ExitCode::usage, "--body has fields of a chat request, expected --agent URL with it");
  if (options.remote.exchanges.empty())
    options.remote.exchanges = (std::filesystem::path(folder_of(options.out)) / "exchanges").string();
  Provenance provenance;
  provenance.tool = "pm-material";
  provenance.options = {{"agent", option_text(options.agent, {"builtin"}, "chat model")},
                        {"predictor", option_text(options.predictor, {"none"}, "inference model")}};
  for (const std::string& input : {options.scene, options.inventory, options.masks, options.state})
    provenance.add_input(input);

  SceneNeeds needs;
  needs.views = true;
  const Scene scene = load_scene(options.scene, needs);
  const Inventory inventory = load_inventory(options.inventory);
  std::vector<std::string> view_names;
  for (const SceneView& view : scene.views) view_names.push_back(view.name);
  require_written_with(options.inventory, options.masks);
  const std::vector<ViewMasks> masks = load_masks(options.masks, inventory, view_names);
  const State state = load_state_rows(options.state, inventory);
  require_made_from(options.state, options.inventory, false, "state");
  require_made_from(options.state, options.masks, false, "state");

  Evidence evidence;
  const std::optional<MaterialRecords> records = observe(options, scene, inventory, masks, evidence, provenance);
  material::reason_about_materials(evidence, inventory, state.gaussians_per_row(),
                                   material::mask_confidences(inventory, masks), records);
  material::take_field(evidence, state);
  for (const EvidenceRow& row : evidence.rows) {
    log_info(row.key + ": " + kLabels[row.label].name + ", P " + std::to_string(row.confidence));
    if (row.field) {
      log_note(material::field_line(row));
    } else if (row.fallback && !row.residual && row.gaussians > 0) {
      const LabelPrior& label = kLabels[row.label];
      log_note(
          fmt::format("no material known for {}: {}, {:.0f} MPa, without evidence; --material (MATERIAL=) changes it",
                      row.key, label.name, 1e-6 * label.E_default()));
    }
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
      "Reads physmas/scene, inventory, masks, state and, with --predictor FILE or --authored, "
      "physmas/material_records; "
      "writes physmas/evidence and, with a model server, exchanges/NAME.json (physmas/exchange).\n"
      "The key for a model server is read from the environment variable PM_API_KEY and written nowhere.\n"
      "The confidence of a row's mask is the mean over the views whose mask is not empty, 0 (unavailable) without any.";
  tool.options = [&](Command app) {
    app.add_option("--scene", options.scene, "scene.json or its slice").required().type_name("FILE");
    app.add_option("--inventory", options.inventory, "inventory.json").required().type_name("FILE");
    app.add_option("--masks", options.masks, "masks.h5").required().type_name("FILE");
    app.add_option("--state", options.state, "state.h5").required().type_name("FILE");
    app.add_option("--out", options.out, "evidence.json to write").required().type_name("FILE");
    app.add_option("--agent", options.agent,
                   "Who looks at the rows: builtin (nobody: schema and roles), the URL of an OpenAI-compatible server "
                   "(http://localhost:8000/v1), or replay:DIR")
        .capture_default_str()
        .type_name("builtin|URL|replay:DIR");
    app.add_option("--model", options.model, "Name of the chat model on that server").type_name("NAME");
    app.add_option("--predictor", options.predictor,
                   "Crop-conditioned E and nu: none, a model behind the Open Inference Protocol v2 "
                   "(http://host/v2/models/NAME), replay:DIR, or a file of records (physmas/material_records)")
        .capture_default_str()
        .type_name("none|URL|replay:DIR|FILE");
    app.add_option(
           "--authored", options.authored,
           "Authored crops and answers, ahead of the predictor's and the agent's, and what rows are stated to be")
        .type_name("FILE");
    remote::add_remote_options(app, options.remote);
    remote::add_chat_options(app, options.remote);
    remote::add_tensor_options(app, options.remote);
  };
  tool.work = [&](const CommonOptions&) { return work(options); };
  return run_tool(argc, argv, tool);
}
