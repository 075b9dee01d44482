// The JSON Schemas of schemas/, embedded by the build.
#ifndef PHYSMAS_RECORDS_SCHEMA_TEXT_H
#define PHYSMAS_RECORDS_SCHEMA_TEXT_H

namespace physmas {

struct SchemaText {
  const char* name;  // file name in schemas/, "inventory.json"
  const char* text;  // the JSON Schema, draft 7
};
extern const SchemaText kSchemaTexts[];
extern const int kSchemaTextCount;

}  // namespace physmas

#endif
