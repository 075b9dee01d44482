// JSON for a page.
#ifndef PHYSMAS_RECORDS_SCRIPT_JSON_H
#define PHYSMAS_RECORDS_SCRIPT_JSON_H

#include <string>

#include "records/json_fwd.h"

namespace physmas {

// On one line, inside a script element: "</script>" and "<!--" would end it.
std::string script_json(const Json& json);

}  // namespace physmas

#endif
