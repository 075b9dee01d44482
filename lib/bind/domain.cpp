#include "bind/domain.h"

#include "base/error.h"
#include "bind/vector.h"

namespace physmas::bind {
namespace {

using Record = RunSpecification::Collider;

mpm::Collider::Mode bind_mode(Record::Mode mode) {
  switch (mode) {
    case Record::Mode::sticky:
      return mpm::Collider::Mode::sticky;
    case Record::Mode::slip:
      return mpm::Collider::Mode::slip;
    case Record::Mode::separate:
      return mpm::Collider::Mode::separate;
  }
  throw internal_error("a collider without a mode");
}

mpm::Collider bind_collider(const Record& record) {
  mpm::Collider collider;
  collider.mode = bind_mode(record.mode);
  collider.friction = record.friction;
  switch (record.type) {
    case Record::Type::plane:
      collider.type = mpm::Collider::Type::plane;
      collider.center = to_mpm(record.point);
      collider.normal = to_mpm(record.normal);
      break;
    case Record::Type::box:
      collider.type = mpm::Collider::Type::box;
      collider.center = to_mpm(0.5 * (record.min + record.max));
      collider.half_size = to_mpm(0.5 * (record.max - record.min));
      break;
    case Record::Type::sphere:
      collider.type = mpm::Collider::Type::sphere;
      collider.center = to_mpm(record.point);
      collider.radius = record.radius;
      break;
  }
  return collider;
}

}  // namespace

mpm::Domain bind_domain(const RunSpecification& run) {
  mpm::Domain domain;
  domain.n = run.grid.n;
  domain.length = run.grid.length;
  domain.gravity = to_mpm(run.gravity);
  domain.wall_cells = run.walls;
  for (const Record& record : run.colliders) domain.colliders.push_back(bind_collider(record));
  return domain;
}

}  // namespace physmas::bind
