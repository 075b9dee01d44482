// The scene agent as a chat model (paper, Appendix "Perception Configuration"): an initial schema query with the front
// view, then one labelled grid of the four views for perception planning and, where a row stays without a mask, repair.
#ifndef PHYSMAS_PLAN_CHAT_AGENT_H
#define PHYSMAS_PLAN_CHAT_AGENT_H

#include <optional>
#include <string>
#include <vector>

#include "plan/scene_geometry.h"
#include "records/provenance.h"
#include "records/queries.h"
#include "remote/chat.h"
#include "scene/view_pictures.h"

namespace physmas::plan {

class ChatAgent {
 public:
  // All references must outlive the agent. pictures: of the scene's views, the front one first.
  ChatAgent(remote::ChatClient& chat, const Scene& scene, const std::vector<ViewPicture>& pictures)
      : chat_(chat), scene_(scene), pictures_(pictures) {}

  // The schema query. registered: the scene's authored inventory, whose objects and rows the answer must keep; null
  // without one. Fills `inventory` (without residual rows where nothing was authored) and returns the proposal, which
  // compile_proposal accepts for it. Errors: exit code 4, see ChatClient::ask.
  Json propose(const Inventory* registered, Inventory& inventory);

  // Perception planning about all keys of `inventory`, or repair of the `missed` ones with what was tried for them.
  // Colours that the agent names become the hints of rows that have none.
  Queries plan_perception(Inventory& inventory, const std::vector<std::string>& missed, const Queries& tried);

  // Answers that were rejected, and why.
  const std::vector<Omission>& rejected() const { return rejected_; }

 private:
  Json ask(const remote::Question& question, const std::string& what);
  std::vector<std::string> view_names() const;

  remote::ChatClient& chat_;
  const Scene& scene_;
  const std::vector<ViewPicture>& pictures_;
  std::vector<Omission> rejected_;
};

// Why an answer to the schema query that fits schemas/scene_reply.json cannot be used; empty when it can. registered:
// as above.
std::string inventory_rejection(const Json& answer, const Inventory* registered);

// Why an answer about `keys` that fits schemas/perception_reply.json cannot be used; empty when it can.
std::string query_rejection(const Json& answer, const std::vector<std::string>& keys,
                            const std::vector<std::string>& view_names);

// The inventory of an answer that inventory_rejection accepts.
Inventory inventory_from_answer(const Json& answer);

}  // namespace physmas::plan

#endif
