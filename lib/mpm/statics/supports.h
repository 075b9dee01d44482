// What holds nodes in place: colliders, walls and particles that the schedule holds, by the rules of the substep's own
// contact (action/collider.h).
#ifndef PHYSMAS_MPM_STATICS_SUPPORTS_H
#define PHYSMAS_MPM_STATICS_SUPPORTS_H

#include <vector>

#include "mpm/domain.h"
#include "mpm/statics/elastic_grid.h"

namespace physmas::mpm::statics {

// The nodes that something touches, and what of their motion it takes at present. A collider that separates does not
// pull, and friction holds against at most friction × the force that presses: which nodes are let go and which slide is
// found from the forces, a little at a time.
class Supports {
 public:
  // held_mass [kg]: of the particles of each node that the schedule holds; a node is held when they are half of it.
  Supports(const Domain& domain, const ElasticGrid& grid, const std::vector<double>& held_mass);

  bool empty() const { return contacts_.empty(); }
  bool touches(size_t node) const { return contact_of_[node] >= 0; }

  // Takes out of a vector per node what supports hold.
  void project(NodeField& field) const;
  // Adds the friction [N] on the nodes that slide.
  void add_friction(NodeField& force) const;
  // force: what acts on the nodes, without supports [N]; u: their displacement since the start [m]. Lets go of nodes
  // that would have to be pulled, lets slide those that friction cannot hold, and takes back those that come against
  // the collider again. Returns how many changed.
  int update(const NodeField& force, const NodeField& u, const std::vector<double>& weight);
  // The force [N] of the supports on a node that they hold, given the force without them.
  Vec3d reaction(size_t node, const Vec3d& force) const;
  // The part of a vector that is free at the node.
  Vec3d free_part(size_t node, const Vec3d& v) const;

 private:
  struct Contact {
    int node;
    bool fixed = false;  // whatever the forces are
    int count = 0;       // of normals
    Vec3d normal[3];     // unit, at right angles to each other, out of the collider
    bool pulls[3] = {};  // whether it also holds against pulling (slip)
    bool open[3] = {};   // let go
    int opened[3] = {};  // how often
    double friction = 0;
    bool sticks = false;      // friction holds all that the normals do not
    Vec3d along = {0, 0, 0};  // of the friction, once it slides: unit
    Vec3d drag = {0, 0, 0};   // [N]
  };
  void add_normal(Contact& c, const Vec3d& normal, bool pulls, double friction) const;
  Vec3d free_part(const Contact& c, Vec3d v) const;
  bool update(Contact& c, const Vec3d& force, const Vec3d& u, double weight) const;

  std::vector<Contact> contacts_;  // by node
  std::vector<int> contact_of_;    // per node; -1: none
};

}  // namespace physmas::mpm::statics

#endif
