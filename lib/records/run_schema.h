// schemas/run.json, from the list of the run specification's fields.
#ifndef PHYSMAS_RECORDS_RUN_SCHEMA_H
#define PHYSMAS_RECORDS_RUN_SCHEMA_H

#include <string>

namespace physmas {

// The text of schemas/run.json. `make schemas` writes it; a test compares.
std::string run_schema_text();

}  // namespace physmas

#endif
