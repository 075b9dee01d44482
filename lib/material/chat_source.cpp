#include "material/chat_source.h"

#include <algorithm>
#include <set>

#include "base/embedded_text.h"
#include "records/json.h"
#include "scene/image_file.h"

namespace physmas::material {

std::string rejection_of(const Json& answer, const std::string& key) {
  if (answer.at("key") != key)
    return "/key: found " + one_line(answer.at("key").dump(), 80) + ", expected \"" + key + "\"";
  const bool abstains = answer.at("abstain").get<bool>();
  const auto check = [&](const char* list, const char* name) -> std::string {
    std::set<std::string> seen;
    double sum = 0;
    for (const Json& entry : answer.at(list)) {
      const std::string label = entry.at(name).get<std::string>();
      if (!seen.insert(label).second) return std::string("/") + list + ": found " + label + " twice, expected it once";
      sum += entry.at("probability").get<double>();
    }
    if (!abstains && list == std::string("labels") && !(sum > 0))
      return "/labels: found no probability, expected some unless abstain is true";
    return "";
  };
  const std::string labels = check("labels", "label");
  return labels.empty() ? check("profiles", "profile") : labels;
}

VlmRecord vlm_record_from(const Json& answer, const std::vector<std::string>& shown) {
  VlmRecord record;
  record.success = true;
  record.abstain = answer.at("abstain").get<bool>();
  record.confidence = answer.at("confidence").get<double>();
  for (const std::string& view : shown) {
    const Json& named = answer.at("visible_views");
    if (std::find(named.begin(), named.end(), view) != named.end()) record.views.push_back(view);
  }
  for (const Json& entry : answer.at("labels"))
    record.probabilities.emplace_back(find_label(entry.at("label").get<std::string>()).value(),
                                      entry.at("probability").get<double>());
  return record;
}

MaterialRecords ask_about_rows(remote::ChatClient& chat, const Inventory& inventory,
                               const std::vector<ViewPicture>& pictures, const std::vector<ViewMasks>& masks,
                               std::vector<Omission>& omitted) {
  MaterialRecords records;
  records.rows.resize(inventory.rows.size());
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    const InventoryRow& row = inventory.rows[r];
    if (row.residual) continue;
    std::vector<const Mask*> shown_masks;
    std::vector<std::string> shown;
    for (size_t v = 0; v < masks.size(); ++v) {
      shown_masks.push_back(&masks[v].rows[r]);
      if (masks[v].rows[r].area() > 0) shown.push_back(masks[v].view);
    }
    if (shown.empty()) {
      omitted.push_back({"the agent's answer about " + row.key(), "no view has a mask of the row"});
      continue;
    }
    remote::Question question;
    question.name = "material_" + row.object + "_" + row.part;
    question.instructions = embedded_text("lib/material/prompts/row.txt");
    const Json subject = {{"key", row.key()},
                          {"object", inventory.objects[inventory.object_of_row(static_cast<int>(r))].name},
                          {"name", row.name},
                          {"structural_role", row.structural_role}};
    question.text = "The row: " + subject.dump() + "\nThe sheet of views follows.";
    question.images = {encode_png(highlighted_sheet(pictures, shown_masks))};
    question.schema = "material_reply";
    question.given = {{"/properties/key", {{"enum", {row.key()}}}}};
    question.reject = [&](const Json& answer) { return rejection_of(answer, row.key()); };
    const remote::Answer answer = chat.ask(question);
    for (const std::string& why : answer.rejected)
      omitted.push_back({"an answer of the agent about " + row.key(), why});
    if (answer.json.at("abstain").get<bool>())
      omitted.push_back({"the agent's evidence about " + row.key(), "the agent abstained"});
    records.rows[r].vlm.push_back(vlm_record_from(answer.json, shown));
  }
  return records;
}

}  // namespace physmas::material
