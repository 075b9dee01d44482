// inventory.json: objects, their parts, and the active-row order (paper, Table "agent-contracts").
#ifndef PHYSMAS_RECORDS_INVENTORY_H
#define PHYSMAS_RECORDS_INVENTORY_H

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "records/provenance.h"

namespace physmas {

// How the built-in segmenter finds an object or a part in the views.
struct AppearanceHints {
  std::vector<Eigen::Vector3d> colors;  // sRGB in 0..1
  double tolerance = 25;                // largest CIELAB distance to one of the colours
  // View name -> polygons in fractions of the image's width and height; inside one of them counts.
  std::map<std::string, std::vector<std::vector<Eigen::Vector2d>>> regions;
  bool empty() const { return colors.empty() && regions.empty(); }
};

struct InventoryObject {
  struct Query {
    std::string view;
    std::string text;
  };
  std::string id;
  std::string name;
  std::string scene_role;
  std::vector<Query> queries;
  AppearanceHints hints;
};

struct InventoryRow {
  std::string object;  // id of its object
  std::string part;    // id within the object
  std::string name;
  std::string structural_role;
  std::string physics_group;
  std::vector<std::string> expected_labels;  // as authored; not yet canonical
  std::vector<std::string> evidence_refs;
  bool residual = false;
  bool named_by_prompt = false;  // its name was read off the prompt: nobody chose its words to describe a material
  AppearanceHints hints;
  std::string key() const { return object + "/" + part; }
};

struct Inventory {
  std::vector<InventoryObject> objects;
  std::vector<InventoryRow> rows;  // the active-row order, used for every tie; HDF5 label arrays store indices into it

  // Index, or -1 when there is none.
  int find_object(const std::string& id) const;
  int find_row(const std::string& key) const;
  // Index of the object that owns row r.
  int object_of_row(int r) const { return find_object(rows[r].object); }
  std::vector<std::string> row_keys() const;
  std::vector<bool> residual_rows() const;  // [rows]
};

// Checks what the schema cannot: unique ids, rows of known objects, every object has a row, at most one residual row
// per object.
Inventory load_inventory(const std::string& path);
// exchanges: with the models that inventory, masks and plan rest on.
void save_inventory(const std::string& path, const Inventory& inventory, const std::vector<Omission>& omitted,
                    const Provenance& provenance, const std::vector<ExchangeReference>& exchanges = {});

}  // namespace physmas

#endif
