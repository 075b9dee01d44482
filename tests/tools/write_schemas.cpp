// Writes the schemas that stem from lists of fields: write_schemas FOLDER.
#include <cstdio>

#include "base/file.h"
#include "records/run_schema.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_schemas FOLDER\n");
    return 2;
  }
  physmas::write_file(std::string(argv[1]) + "/run.json", physmas::run_schema_text());
  return 0;
}
