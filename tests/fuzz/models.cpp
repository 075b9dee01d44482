// What models answer. Input: a letter for who is asked (below), then one answer per question, with 0x1e between. A chat
// model's answer is the text of its message, except for 'w': there it is the whole completion.
#include "guard.h"
#include "masks/mask_models.h"
#include "material/chat_source.h"
#include "material/predictor_source.h"
#include "plan/action_proposal.h"
#include "plan/chat_agent.h"
#include "plan/scene_inventory.h"
#include "records/json.h"
#include "scene/image_file.h"

namespace {

using namespace physmas;

class Answers : public remote::Backend {
 public:
  Answers(std::string text, bool wrapped) : rest_(std::move(text)), wrapped_(wrapped) {}

  remote::Reply exchange(const remote::Request& request) override {
    // As for the network. The rest of a question, its answer's schema above all, is not made of answers.
    if (request.body.contains("messages")) request.body.at("messages").dump();
    remote::Reply reply;
    reply.status = 200;
    if (!request.wants_json) return reply;
    const size_t end = rest_.find('\x1e');
    std::string text = rest_.substr(0, end);
    rest_ = end == std::string::npos ? "" : rest_.substr(end + 1);
    if (wrapped_) {
      const Json completion = {{"choices", {{{"finish_reason", "stop"}, {"message", {{"content", text}}}}}}};
      text = compact_text(completion);
    }
    reply.body = remote::parse_reply(text, request.name);
    return reply;
  }
  bool is_recorded() const override { return false; }

 private:
  std::string rest_;
  bool wrapped_;
};

// The lollipop of tests/data/tiny.json, as its only view shows it.
struct World {
  World() {
    scene.file = "scene.json";
    scene.prompt = "the lollipop is pressed";
    SceneView view;
    view.name = "front";
    view.camera.width = 8, view.camera.height = 2;
    view.camera.fx = view.camera.fy = 8;
    scene.views = {view};
    pictures = {{"front", Image(8, 2, 3)}};
    inventory.objects.emplace_back();
    inventory.objects.back().id = inventory.objects.back().name = "lollipop";
    for (const char* part : {"stick", "candy"}) {
      inventory.rows.emplace_back();
      inventory.rows.back().object = "lollipop";
      inventory.rows.back().part = inventory.rows.back().name = part;
    }
    plan::complete_inventory(inventory, {"front"}, "inventory.json");
    Mask mask;
    mask.width = 8, mask.height = 2;
    mask.pixels.assign(16, 255);
    masks.resize(1);
    masks[0].view = "front";
    masks[0].objects = {mask};
    masks[0].rows = {mask, Mask(), Mask()};
    png = encode_png(pictures[0].rgb);
  }

  Scene scene;
  std::vector<ViewPicture> pictures;
  Inventory inventory;
  std::vector<ViewMasks> masks;
  std::string png;
};

void ask(char who, const std::string& text, const World& world) {
  Answers answers(text, who != 'w' && std::islower(static_cast<unsigned char>(who)));
  remote::ChatClient chat(answers, "model");
  switch (who) {
    case 'w':
    case 's': {  // the scene agent, then what it plans to look for
      plan::ChatAgent agent(chat, world.scene, world.pictures);
      Inventory inventory;
      const Json proposal = agent.propose(nullptr, inventory);
      plan::complete_inventory(inventory, {"front"}, "answer");
      const plan::SceneGeometry geometry = plan::measure_scene(world.scene, Inventory(), {});
      plan::compile_proposal(proposal, world.scene.prompt, inventory, geometry, world.scene.run);
      agent.plan_perception(inventory, {}, {});
      break;
    }
    case 'r': {  // the scene agent with a registered inventory
      plan::ChatAgent agent(chat, world.scene, world.pictures);
      Inventory inventory;
      agent.propose(&world.inventory, inventory);
      agent.plan_perception(inventory, {"lollipop/stick"}, {});
      break;
    }
    case 'm': {  // the material agent
      std::vector<Omission> omitted;
      material::ask_about_rows(chat, world.inventory, world.pictures, world.masks, omitted);
      break;
    }
    case 'P':  // the predictor: its metadata, then a reply per row and one for the whole object
    {
      remote::InferenceClient client(answers, "predictor");
      material::predict_rows(client, world.inventory, world.pictures, world.masks);
      break;
    }
    case 'D': {  // detector and segmenter: the metadata of both, then a reply of each
      masks::MaskModels models(answers, answers);
      models.find("front_1", world.png, "a lollipop", 8, 2);
      break;
    }
    default:
      break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const World world;
  if (size < 1) return 0;
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  guard([&] { ask(static_cast<char>(data[0]), text, world); });
  return 0;
}
