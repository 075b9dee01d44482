// What perception looks for: one text per object and semantic row, in the views that show it.
#ifndef PHYSMAS_RECORDS_QUERIES_H
#define PHYSMAS_RECORDS_QUERIES_H

#include <map>
#include <string>
#include <vector>

namespace physmas {

struct Query {
  std::string text;
  std::vector<std::string> views;
};
using Queries = std::map<std::string, Query>;  // by object id and row key; absent: not looked for

}  // namespace physmas

#endif
