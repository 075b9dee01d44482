// The vision-language source: a chat model asked once per semantic row with one highlighted multi-view sheet.
#ifndef PHYSMAS_MATERIAL_CHAT_SOURCE_H
#define PHYSMAS_MATERIAL_CHAT_SOURCE_H

#include <vector>

#include "material/pictures.h"
#include "records/inventory.h"
#include "records/material_records.h"
#include "remote/chat.h"

namespace physmas::material {

// One VLM record per semantic row that some view shows; rows that no view shows are not asked about and listed in
// `omitted`, and so are answers that were rejected. An answer's visible views are those that it names and that have a
// mask of the row. Errors: exit code 4, see ChatClient::ask.
MaterialRecords ask_about_rows(remote::ChatClient& chat, const Inventory& inventory,
                               const std::vector<ViewPicture>& pictures, const std::vector<ViewMasks>& masks,
                               std::vector<Omission>& omitted);

// The record of an answer that fits schemas/material_reply.json. shown: views with a mask of the row.
VlmRecord vlm_record_from(const Json& answer, const std::vector<std::string>& shown);

// Why an answer about `key` cannot be used although it fits the schema; empty when it can.
std::string rejection_of(const Json& answer, const std::string& key);

}  // namespace physmas::material

#endif
