#include "studies/stiff_cases.h"

#include <cmath>

#include "base/random.h"
#include "mpm/rigid/rigid_body.h"

namespace physmas::studies {
namespace {

using mpm::Mat3d;
using mpm::Vec3d;

constexpr double kCell = 0.02;
constexpr double kWallHeight = 3 * kCell;  // the wall's
constexpr double kSoftModulus = 1e5;       // Pa

class Scene {
 public:
  Scene(std::string name, std::string text, double duration, double youngs_modulus) : stiff_(youngs_modulus) {
    case_.name = std::move(name);
    case_.text = std::move(text);
    case_.duration = duration;
    case_.problem.domain.n = 50;
    case_.problem.domain.length = 50 * kCell;
  }
  StiffCase take() { return std::move(case_); }
  StiffCase* operator->() { return &case_; }

  int stiff() {
    case_.stiff.push_back(row({mpm::Branch::jelly, stiff_, 0.3, 2000}));
    return case_.stiff.back();
  }
  int soft() { return row({mpm::Branch::jelly, kSoftModulus, 0.3, 1000}); }

  // Eight particles per cell in `cells` from `low`, where `inside` (of the unturned place) says so; turned about the
  // block's centre.
  struct Motion {
    Mat3d rotation = mpm::identity<double>();
    Vec3d velocity = {0, 0, 0}, spin = {0, 0, 0};
    double jitter = 0;  // of dx
  };
  template <class Inside>
  void block(int row, const Vec3d& low, const Vec3d& cells, const Motion& motion, const Inside& inside) {
    mpm::Particles& p = case_.problem.particles;
    const Vec3d center = low + (0.5 * kCell) * cells;
    Random random(1);
    for (int i = 0; i < std::lround(2 * cells.x); ++i) {
      for (int j = 0; j < std::lround(2 * cells.y); ++j) {
        for (int k = 0; k < std::lround(2 * cells.z); ++k) {
          Vec3d x = low + (0.5 * kCell) * Vec3d{i + 0.5, j + 0.5, k + 0.5};
          for (int a = 0; a < 3 && motion.jitter > 0; ++a) x[a] += 0.5 * motion.jitter * kCell * random.symmetric();
          if (!inside(x)) continue;
          const Vec3d d = motion.rotation * (x - center);
          p.position.push_back(center + d);
          p.velocity.push_back(motion.velocity + cross(motion.spin, d));
          p.volume.push_back(kCell * kCell * kCell / 8);
          p.row.push_back(row);
        }
      }
    }
  }
  void block(int row, const Vec3d& low, const Vec3d& cells, const Motion& motion) {
    block(row, low, cells, motion, [](const Vec3d&) { return true; });
  }
  void block(int row, const Vec3d& low, const Vec3d& cells) { block(row, low, cells, Motion()); }

 private:
  int row(const mpm::Material& material) {
    case_.problem.materials.push_back(material);
    case_.problem.object.push_back(static_cast<int>(case_.problem.object.size()));
    return static_cast<int>(case_.problem.materials.size()) - 1;
  }
  double stiff_;
  StiffCase case_;
};

Mat3d turned(const Vec3d& by) {
  return mpm::rotation_by(by);
}

// Cases that the constants of the method were fixed on.
void add_tuned(std::vector<StiffCase>& cases, double E) {
  {
    Scene s("block-on-soft", "A stiff block falls at 1.5 m/s onto a soft one.", 0.25, E);
    const int soft = s.soft(), stiff = s.stiff();
    s.block(soft, {0.4, 0.4, kWallHeight + 0.01}, {10, 10, 5});
    s.block(stiff, {0.45, 0.46, kWallHeight + 0.16}, {5, 5, 5}, {mpm::identity<double>(), {0, 0, -1.5}});
    cases.push_back(s.take());
  }
  {
    Scene s("plate-impulse", "A stiff plate with a soft block on it gets an impulse at one edge.", 0.15, E);
    const int stiff = s.stiff(), soft = s.soft();
    s.block(stiff, {0.34, 0.34, 0.3}, {16, 16, 1});
    s.block(soft, {0.44, 0.44, 0.325}, {6, 6, 4});
    mpm::Particles& p = s->problem.particles;
    for (size_t i = 0; i < p.size(); ++i) {
      if (p.row[i] == stiff && p.position[i].x > 0.34 + 13 * kCell && std::fabs(p.position[i].y - 0.5) < 2 * kCell)
        p.velocity[i].z += 10;
    }
    s->goal_stiff = 0.003;
    cases.push_back(s.take());
  }
  {
    Scene s("rod-three-hits",
            "A tilted stiff rod of jittered particles falls and hits the floor with one end, then the other.", 0.3, E);
    s.block(s.stiff(), {0.3, 0.48, 0.25}, {20, 2, 2},
            {turned({0, 0, 0.35}) * turned({0, 0.7, 0}), {0, 0, -1}, {0, 0, 0}, 0.4});
    s->goal_stiff = 0.02;
    cases.push_back(s.take());
  }
  {
    Scene s("flat-bounce", "A stiff cube falls flat at 2 m/s onto the floor.", 0.15, E);
    s.block(s.stiff(), {0.44, 0.44, kWallHeight + 0.06}, {6, 6, 6}, {mpm::identity<double>(), {0, 0, -2}});
    s->goal_stiff = 0.005;
    cases.push_back(s.take());
  }
  {
    Scene s("two-blocks", "Two stiff cubes meet off centre, without gravity.", 0.15, E);
    s->problem.domain.gravity = {0, 0, 0};
    const int one = s.stiff(), two = s.stiff();
    s.block(one, {0.3, 0.44, 0.44}, {6, 6, 6}, {mpm::identity<double>(), {1, 0, 0}});
    s.block(two, {0.52, 0.47, 0.46}, {6, 6, 6}, {mpm::identity<double>(), {-1, 0, 0}});
    cases.push_back(s.take());
  }
  {
    Scene s("tilted-cube", "A tilted stiff cube falls at 2 m/s onto one corner.", 0.2, E);
    s.block(s.stiff(), {0.44, 0.44, kWallHeight + 0.09}, {6, 6, 6}, {turned({0.3, 0.5, 0}), {0, 0, -2}});
    cases.push_back(s.take());
  }
  {
    Scene s("plate-and-cake", "A stiff plate with a soft block above it drops on the floor.", 0.2, E);
    const int stiff = s.stiff(), soft = s.soft();
    s.block(stiff, {0.38, 0.38, kWallHeight + 0.035}, {12, 12, 1});
    s.block(soft, {0.44, 0.44, kWallHeight + 0.075}, {6, 6, 4});
    s->goal_stiff = 0.01, s->goal_other = 0.02;
    cases.push_back(s.take());
  }
  {
    Scene s("stack", "A stiff cube falls at 0.5 m/s onto a larger one above the floor.", 0.2, E);
    const int below = s.stiff(), above = s.stiff();
    s.block(below, {0.4, 0.4, kWallHeight + 0.03}, {8, 8, 4});
    s.block(above, {0.45, 0.44, kWallHeight + 0.18}, {4, 4, 4}, {mpm::identity<double>(), {0, 0, -0.5}});
    cases.push_back(s.take());
  }
  {
    Scene s("tray-lands", "A tilted stiff tray with a soft block on it lands at 1 m/s.", 0.2, E);
    const int stiff = s.stiff(), soft = s.soft();
    const Mat3d R = turned({0.15, 0.2, 0});
    s.block(stiff, {0.36, 0.36, 0.22}, {12, 12, 1}, {R, {0, 0, -1}});
    const size_t first = s->problem.particles.size();
    s.block(soft, {0.44, 0.44, 0.25}, {6, 6, 4}, {mpm::identity<double>(), {0, 0, -1}});
    mpm::Particles& p = s->problem.particles;
    const Vec3d center = {0.48, 0.48, 0.23};
    for (size_t i = first; i < p.size(); ++i) p.position[i] = center + R * (p.position[i] - center);
    cases.push_back(s.take());
  }
}

// Cases that nothing was tuned on.
void add_held_out(std::vector<StiffCase>& cases, double E) {
  const auto add = [&](Scene& s) {
    s->held_out = true;
    cases.push_back(s.take());
  };
  {
    Scene s("mug-on-cushion", "A stiff mug falls tilted at 1 m/s onto a soft cushion.", 0.25, E);
    const int cushion = s.soft(), mug = s.stiff();
    s.block(cushion, {0.34, 0.34, kWallHeight}, {16, 16, 4});
    const Vec3d low = {0.42, 0.44, kWallHeight + 0.14};
    s.block(mug, low, {6, 6, 8}, {turned({0.2, 0.35, 0}), {0, 0, -1}}, [&](const Vec3d& x) {
      const double r = std::hypot(x.x - low.x - 3 * kCell, x.y - low.y - 3 * kCell);
      return r < 3 * kCell && (r > 1.9 * kCell || x.z < low.z + 1.1 * kCell);
    });
    add(s);
  }
  {
    Scene s("hammer-and-cake", "A stiff hammer swings onto a soft cake.", 0.25, E);
    const int cake = s.soft(), hammer = s.stiff();
    s.block(cake, {0.3, 0.4, kWallHeight}, {12, 10, 5});
    const Vec3d grip = {0.72, 0.5, 0.36};
    s.block(hammer, {0.38, 0.44, 0.28}, {4, 6, 5});
    s.block(hammer, {0.46, 0.48, 0.33}, {13, 2, 2});
    mpm::Particles& p = s->problem.particles;
    for (size_t i = 0; i < p.size(); ++i) {
      if (p.row[i] == hammer) p.velocity[i] = cross(Vec3d{0, -6, 0}, p.position[i] - grip);
    }
    add(s);
  }
  {
    Scene s("stack-topples", "The upper of two stiff blocks leans over the edge of the lower one.", 0.4, E);
    const int below = s.stiff(), above = s.stiff();
    s.block(below, {0.4, 0.42, kWallHeight}, {5, 6, 6});
    s.block(above, {0.46, 0.44, kWallHeight + 0.13}, {5, 4, 7}, {turned({0, 0.12, 0})});
    add(s);
  }
  {
    Scene s("wheel-rolls", "A stiff wheel rolls over a rough floor at 1 m/s.", 0.3, E);
    mpm::Collider floor;
    floor.center = {0, 0, kWallHeight};
    floor.friction = 0.6;
    s->problem.domain.colliders.push_back(floor);
    const Vec3d low = {0.2, 0.46, kWallHeight + 0.01};
    const double radius = 6 * kCell;
    const Vec3d center = low + Vec3d{radius, 2 * kCell, radius};
    Scene::Motion motion;
    motion.velocity = {1, 0, 0};
    motion.spin = {0, 1 / radius, 0};
    s.block(s.stiff(), low, {12, 4, 12}, motion,
            [&](const Vec3d& x) { return std::hypot(x.x - center.x, x.z - center.z) < radius; });
    add(s);
  }
  {
    Scene s("chair-on-two-legs", "A stiff chair stands on its back legs and falls forward.", 0.4, E);
    const int chair = s.stiff();
    // Tilted as one: blocks are placed first and turned together.
    const Vec3d corner = {0.4, 0.4, kWallHeight + 0.01};
    for (const double x : {0.0, 6 * kCell})
      for (const double y : {0.0, 6 * kCell}) s.block(chair, corner + Vec3d{x, y, 0}, {2, 2, 6});
    s.block(chair, corner + Vec3d{0, 0, 6 * kCell}, {8, 8, 2});
    s.block(chair, corner + Vec3d{0, 0, 8 * kCell}, {2, 8, 6});
    const Mat3d R = turned({0, -0.25, 0});
    for (Vec3d& x : s->problem.particles.position) x = corner + R * (x - corner);
    double lowest = 1;
    for (const Vec3d& x : s->problem.particles.position) lowest = std::fmin(lowest, x.z);
    for (Vec3d& x : s->problem.particles.position) x.z += kWallHeight + 0.008 - lowest;
    add(s);
  }
  {
    Scene s("bell-and-ball", "A stiff ball at 3 m/s hits the rim of a stiff bell, without gravity.", 0.15, E);
    s->problem.domain.gravity = {0, 0, 0};
    const int bell = s.stiff(), ball = s.stiff();
    const Vec3d low = {0.5, 0.4, 0.4}, middle = {0.6, 0.5, 0.4};
    s.block(bell, low, {10, 10, 10}, Scene::Motion(), [&](const Vec3d& x) {
      const double r = norm(x - middle);
      return r < 0.1 * 1.7 && std::hypot(x.x - middle.x, x.y - middle.y) < 0.1 && r > 0.1 * 1.3;
    });
    const Vec3d start = {0.3, 0.45, 0.52};
    s.block(ball, start, {4, 4, 4}, {mpm::identity<double>(), {3, 0, 0}}, [&](const Vec3d& x) {
      return norm(x - start - Vec3d{0.04, 0.04, 0.04}) < 0.04;
    });
    add(s);
  }
}

}  // namespace

std::vector<StiffCase> stiff_cases(double youngs_modulus) {
  std::vector<StiffCase> cases;
  add_tuned(cases, youngs_modulus);
  add_held_out(cases, youngs_modulus);
  return cases;
}

StiffCase all_soft(StiffCase c) {
  for (const int row : c.stiff) c.problem.materials[row].E = kSoftModulus;
  return c;
}

}  // namespace physmas::studies
