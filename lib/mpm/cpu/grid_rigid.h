// The nodes of rigid bodies (mpm/rigid), each of which has a field of its own: field 1 + b of body b. What is not rigid
// has field 0, and everything moves with the velocities written there.
#ifndef PHYSMAS_MPM_CPU_GRID_RIGID_H
#define PHYSMAS_MPM_CPU_GRID_RIGID_H

#include "mpm/cpu/grid.h"

namespace physmas::mpm {

template <class T>
struct Grid<T>::RigidBlock {
  int index = 0;                        // of the active block
  std::uint64_t in_obstacle = 0;        // a bit per node
  std::vector<NodeObstacle> obstacles;  // of those nodes, one after the other
  std::uint16_t obstacle_bounds[kBlockNodes + 1] = {};
  // What `collect` finds: per body that reaches the block, in their order, the sums about the block's first node.
  std::vector<NodeMoments> moments;
  std::vector<HeldNode> held;
  std::vector<BodyPair> pairs;
  std::vector<Vec3d> push;  // per body

  NodeObstacles at(int node) const {
    return {obstacles.data() + obstacle_bounds[node], obstacle_bounds[node + 1] - obstacle_bounds[node]};
  }
};

// The nodes of a block, in doubles.
template <class T>
struct Grid<T>::RigidNodes {
  int bodies = 0, body[kMostRigidBodies];                      // those that reach the block
  alignas(64) double mass[kMostRigidBodies + 1][kBlockNodes];  // kg; last: what belongs to none, in slot `bodies`
  double u[kMostRigidBodies + 1][3][kBlockNodes];              // m/s, of each alone
  double total[kBlockNodes], mean[3][kBlockNodes];             // kg; m/s of all together
  std::uint8_t sharing[kBlockNodes];                           // bodies that have mass at the node
  std::uint64_t listed = 0;                                    // a bit per node: in an obstacle, or of several bodies
};

template <class T>
void Grid<T>::prepare_rigid() {
  rigid_blocks_.clear();
  rigid_block_of_.assign(map_.grid_blocks.size(), -1);
  for (size_t b = 0; b < map_.grid_blocks.size(); ++b) {
    if ((map_.grid_blocks[b].bodies >> 1) == 0) continue;
    rigid_block_of_[b] = static_cast<int>(rigid_blocks_.size());
    RigidBlock block;
    block.index = static_cast<int>(b);
    find_held_nodes(block);
    rigid_blocks_.push_back(std::move(block));
  }
  rigid_nodes_.resize(rigid_blocks_.size());
}

template <class T>
std::vector<char> Grid<T>::near_rigid() const {
  std::vector<char> near(setup_.rigid.bodies.size(), 0);
  for (const RigidBlock& r : rigid_blocks_) {
    const unsigned bodies = map_.grid_blocks[r.index].bodies >> 1;
    const bool meets = r.in_obstacle != 0 || (bodies & (bodies - 1)) != 0;
    for (size_t b = 0; meets && b < near.size(); ++b) near[b] |= bodies >> b & 1;
  }
  return near;
}

template <class T>
void Grid<T>::find_held_nodes(RigidBlock& block) const {
  const GridBlock& grid = map_.grid_blocks[block.index];
  for (int i = 0; i < kBlockNodes; ++i) {
    block.obstacle_bounds[i] = static_cast<std::uint16_t>(block.obstacles.size());
    if (obstacle_[block.index] == 0) continue;
    const int at[3] = {kBlock * grid.position[0] + i / 16, kBlock * grid.position[1] + i / 4 % 4,
                       kBlock * grid.position[2] + i % 4};
    find_obstacles(setup_.domain, at, {at[0] * dx_, at[1] * dx_, at[2] * dx_}, block.obstacles);
    if (block.obstacles.size() > block.obstacle_bounds[i]) block.in_obstacle |= std::uint64_t(1) << i;
  }
  block.obstacle_bounds[kBlockNodes] = static_cast<std::uint16_t>(block.obstacles.size());
}

template <class T>
void Grid<T>::gather_nodes(const RigidBlock& block, double dt, RigidNodes& nodes) const {
  const GridBlock& grid = map_.grid_blocks[block.index];
  nodes.bodies = 0;
  for (unsigned left = grid.bodies >> 1; left != 0; left &= left - 1) {
    nodes.body[nodes.bodies++] = __builtin_ctz(left);
  }
  const Vec3d fall = dt * setup_.domain.gravity;
  alignas(64) double p[3][kBlockNodes] = {};
  std::fill_n(nodes.total, kBlockNodes, 0.0);
  std::fill_n(nodes.sharing, kBlockNodes, std::uint8_t(0));
  for (int k = 0; k <= nodes.bodies; ++k) {
    const int f = k < nodes.bodies ? 1 + nodes.body[k] : 0;
    alignas(64) T row[4 * kBlockNodes] = {};
    if ((grid.bodies >> f & 1) != 0) {
      for_each_node_row(grid, [&](int r, size_t at) {
        std::memcpy(row + kNodeRow * r, fields_[f].momentum.data() + at, kNodeRow * sizeof(T));
      });
    }
    const bool counts = k < nodes.bodies;
    for (int i = 0; i < kBlockNodes; ++i) {
      const double m = row[4 * i];
      nodes.mass[k][i] = m;
      nodes.total[i] += m;
      nodes.sharing[i] = static_cast<std::uint8_t>(nodes.sharing[i] + (counts && m > 0));
      for (int a = 0; a < 3; ++a) p[a][i] += row[4 * i + 1 + a];
    }
    // Of each alone: where several bodies may share nodes.
    for (int i = 0; nodes.bodies > 1 && i < kBlockNodes; ++i) {
      const double inverse = row[4 * i] > 0 ? 1 / double(row[4 * i]) : 0;
      for (int a = 0; a < 3; ++a) nodes.u[k][a][i] = row[4 * i + 1 + a] * inverse + fall[a];
    }
  }
  for (int a = 0; a < 3; ++a) {
    for (int i = 0; i < kBlockNodes; ++i) {
      const double m = nodes.total[i];
      nodes.mean[a][i] = m > 0 ? p[a][i] / m + fall[a] : 0;
    }
  }
  nodes.listed = block.in_obstacle;
  for (int i = 0; nodes.bodies > 1 && i < kBlockNodes; ++i) {
    nodes.listed |= std::uint64_t(nodes.sharing[i] > 1) << i;
  }
}

// What belongs to no body goes with the bodies at a node by their masses.
template <class T>
static PHYSMAS_INLINE void share_of_body(const T& nodes, int k, int i, double& mass, Vec3d& u) {
  const double loose = nodes.mass[nodes.bodies][i], own = nodes.mass[k][i];
  double rigid = 0;
  for (int j = 0; j < nodes.bodies; ++j) rigid += nodes.mass[j][i];
  const double part = loose * own / rigid;
  mass = own + part;
  for (int a = 0; a < 3; ++a) u[a] = (own * nodes.u[k][a][i] + part * nodes.u[nodes.bodies][a][i]) / mass;
}

namespace rigid_detail {

// Adds Σ w (1, x, x xᵀ, u, x uᵀ) over a block's nodes, x from its first.
inline void add_moments(const double* w, const double* ux, const double* uy, const double* uz, double dx,
                        NodeMoments& out) {
  double s[22] = {};
  for (int i = 0; i < kBlockNodes; ++i) {
    const double x = i / 16, y = i / 4 % 4, z = i % 4;
    const double m = w[i], mx = m * x, my = m * y, mz = m * z;
    s[0] += m, s[1] += mx, s[2] += my, s[3] += mz;
    s[4] += mx * x, s[5] += my * y, s[6] += mz * z, s[7] += mx * y, s[8] += mx * z, s[9] += my * z;
    s[10] += m * ux[i], s[11] += m * uy[i], s[12] += m * uz[i];
    s[13] += mx * ux[i], s[14] += mx * uy[i], s[15] += mx * uz[i];
    s[16] += my * ux[i], s[17] += my * uy[i], s[18] += my * uz[i];
    s[19] += mz * ux[i], s[20] += mz * uy[i], s[21] += mz * uz[i];
  }
  out.w += s[0];
  for (int a = 0; a < 3; ++a) {
    out.wx[a] += dx * s[1 + a];
    out.wu[a] += s[10 + a];
    for (int b = 0; b < 3; ++b) out.wxu[a][b] += dx * s[13 + 3 * a + b];
  }
  for (int k = 0; k < 6; ++k) out.wxx[k] += dx * dx * s[4 + k];
}

}  // namespace rigid_detail

// First half: what the bodies' twists are found from.
template <class T>
void Grid<T>::collect(RigidBlock& block, RigidNodes& nodes, double dt, const RigidMotion& rigid) const {
  gather_nodes(block, dt, nodes);
  const GridBlock& grid = map_.grid_blocks[block.index];
  const Vec3d first = {kBlock * grid.position[0] * dx_, kBlock * grid.position[1] * dx_,
                       kBlock * grid.position[2] * dx_};
  const auto place = [&](int i) { return first + Vec3d{(i / 16) * dx_, (i / 4 % 4) * dx_, (i % 4) * dx_}; };
  block.moments.assign(nodes.bodies, {});
  block.held.clear();
  block.pairs.clear();
  for (int k = 0; k < nodes.bodies; ++k) {
    const int body = nodes.body[k];
    const double share = rigid.lock_share(body, dt);
    alignas(64) double weight[kBlockNodes];
    for (int i = 0; i < kBlockNodes; ++i) {
      const double lock = nodes.mass[k][i] * share, mass = nodes.total[i];
      weight[i] = mass > 0 ? mass * lock / (mass + lock) : 0;
    }
    for (std::uint64_t left = nodes.listed; left != 0; left &= left - 1) {
      const int i = __builtin_ctzll(left);
      weight[i] = 0;
      if (!(nodes.mass[k][i] > 0)) continue;
      HeldNode node;
      node.body = body;
      node.from_center = place(i) - rigid.body(body).center;
      if (nodes.sharing[i] > 1) {
        share_of_body(nodes, k, i, node.mass, node.u);
      } else {
        node.mass = nodes.total[i], node.u = {nodes.mean[0][i], nodes.mean[1][i], nodes.mean[2][i]};
      }
      node.lock = nodes.mass[k][i] * share;
      node.obstacles = block.at(i);
      block.held.push_back(node);
    }
    rigid_detail::add_moments(weight, nodes.mean[0], nodes.mean[1], nodes.mean[2], dx_, block.moments[k]);
  }
  const std::ptrdiff_t step[3] = {layout.step_x(), layout.step_y(), 4};
  const auto gradient = [&](int body, int i) {
    const T* const mass = fields_[1 + body].momentum.data() + offset(grid.position) + (i / 16) * layout.step_x() +
                          (i / 4 % 4) * layout.step_y() + 4 * (i % 4);
    Vec3d g;
    for (int a = 0; a < 3; ++a) g[a] = 0.5 * (double(mass[step[a]]) - double(mass[-step[a]])) / double(*mass);
    return g;
  };
  for (int i = 0; nodes.bodies > 1 && i < kBlockNodes; ++i) {
    if (nodes.sharing[i] < 2) continue;
    for (int k = 0; k < nodes.bodies; ++k) {
      for (int l = k + 1; l < nodes.bodies; ++l) {
        if (!(nodes.mass[k][i] > 0) || !(nodes.mass[l][i] > 0)) continue;
        BodyPair pair;
        pair.body[0] = nodes.body[k], pair.body[1] = nodes.body[l];
        for (int s = 0; s < 2; ++s) pair.from_center[s] = place(i) - rigid.body(pair.body[s]).center;
        const double one = nodes.mass[k][i] * rigid.lock_share(pair.body[0], dt);
        const double two = nodes.mass[l][i] * rigid.lock_share(pair.body[1], dt);
        pair.lock = one * two / (one + two);
        const Vec3d between = gradient(pair.body[1], i) - gradient(pair.body[0], i);
        const double length = norm(between);
        pair.normal = length > 0 ? (1 / length) * between : Vec3d{0, 0, 0};
        block.pairs.push_back(pair);
      }
    }
  }
}

template <class T>
void Grid<T>::measure_rigid_nodes(const RigidBlock& block, const RigidNodes& nodes,
                                  const double (&left)[3][kBlockNodes], const double (&locked)[3][kBlockNodes],
                                  bool held) {
  const GridBlock& grid = map_.grid_blocks[block.index];
  GridEnergy& energy = energy_[block.index];
  energy = {};
  for_each_node_row(grid, [&](int r, size_t at) {
    for (int z = 0; z < kBlock; ++z) {
      const int i = kBlock * r + z;
      double mass = 0;
      Vec3d momentum = {0, 0, 0};
      for (size_t f = 0; f < fields_.size(); ++f) {
        if ((grid.bodies >> f & 1) == 0) continue;
        const T* const from = fields_[f].force_free.data() + at + 4 * z;
        mass += from[0];
        for (int a = 0; a < 3; ++a) momentum[a] += from[1 + a];
      }
      if (!(mass > 0)) continue;
      const Vec3d brought = (1 / mass) * momentum, free = {nodes.mean[0][i], nodes.mean[1][i], nodes.mean[2][i]};
      const Vec3d u = {left[0][i], left[1][i], left[2][i]}, lock = {locked[0][i], locked[1][i], locked[2][i]};
      energy.arrived += 0.5 * mass * dot(brought, brought);
      energy.left += 0.5 * mass * dot(u, u);
      energy.contact += 0.5 * mass * dot(u - lock, brought + u);
      energy.rigid += 0.5 * mass * dot(lock - free, brought + u);
      for (int k = 0; held && k < nodes.bodies; ++k) energy.rigid_left += 0.5 * nodes.mass[k][i] * dot(u, u);
    }
  });
}

// Second half: node velocities, and what of them is each body's.
template <class T>
template <bool kMeasure>
double Grid<T>::update_rigid_block(RigidBlock& block, RigidNodes& nodes, double dt, const RigidMotion& rigid) {
  const bool held = rigid.held();
  if (!held) gather_nodes(block, dt, nodes);
  const GridBlock& grid = map_.grid_blocks[block.index];
  const Vec3d first = {kBlock * grid.position[0] * dx_, kBlock * grid.position[1] * dx_,
                       kBlock * grid.position[2] * dx_};
  alignas(64) double own[kMostRigidBodies][3][kBlockNodes];  // what each body's mass moves with
  alignas(64) double left[3][kBlockNodes];                   // what the nodes move with
  alignas(64) double locked[3][kBlockNodes];                 // the same without obstacles
  std::memcpy(left, nodes.mean, sizeof(left));
  block.push.assign(nodes.bodies, {0, 0, 0});
  for (int k = 0; held && k < nodes.bodies; ++k) {
    const double share = rigid.lock_share(nodes.body[k], dt);
    const Twist& twist = rigid.twists()[nodes.body[k]];
    const Vec3d spin = twist.spin, base = twist.at(first - rigid.body(nodes.body[k]).center);
    for (int i = 0; i < kBlockNodes; ++i) {
      const double x = (i / 16) * dx_, y = (i / 4 % 4) * dx_, z = (i % 4) * dx_;
      const double lock = nodes.mass[k][i] * share, mass = nodes.total[i];
      const double pull = lock > 0 ? lock / (mass + lock) : 0;
      const double U[3] = {base.x + spin.y * z - spin.z * y, base.y + spin.z * x - spin.x * z,
                           base.z + spin.x * y - spin.y * x};
      for (int a = 0; a < 3; ++a) {
        left[a][i] += pull * (U[a] - left[a][i]);
        own[k][a][i] = left[a][i];
      }
    }
  }
  if (kMeasure) std::memcpy(locked, left, sizeof(locked));
  for (std::uint64_t bits = nodes.listed; bits != 0; bits &= bits - 1) {
    const int i = __builtin_ctzll(bits);
    if (!(nodes.total[i] > 0)) continue;
    const Vec3d free = {nodes.mean[0][i], nodes.mean[1][i], nodes.mean[2][i]};
    const NodeObstacles obstacles = block.at(i);
    if (!held || nodes.sharing[i] == 0) {
      const Vec3d u = obstacles.apply(free), taken = u - free;
      for (int a = 0; a < 3; ++a) left[a][i] = u[a];
      for (int k = 0; !held && k < nodes.bodies; ++k) {
        Vec3d change = taken;
        if (nodes.sharing[i] > 1 && nodes.mass[k][i] > 0) {
          change = u - Vec3d{nodes.u[k][0][i], nodes.u[k][1][i], nodes.u[k][2][i]};
        }
        block.push[k] = block.push[k] + nodes.mass[k][i] * change;
      }
      continue;
    }
    const Vec3d x = first + Vec3d{(i / 16) * dx_, (i / 4 % 4) * dx_, (i % 4) * dx_};
    Vec3d sum = {0, 0, 0}, pulled_sum = {0, 0, 0};
    double mass = 0;
    for (int k = 0; k < nodes.bodies; ++k) {
      if (!(nodes.mass[k][i] > 0)) continue;
      HeldNode node;
      node.body = nodes.body[k];
      node.lock = nodes.mass[k][i] * rigid.lock_share(node.body, dt);
      if (nodes.sharing[i] > 1) {
        share_of_body(nodes, k, i, node.mass, node.u);
      } else {
        node.mass = nodes.total[i], node.u = free;
      }
      const Vec3d U = rigid.twists()[node.body].at(x - rigid.body(node.body).center);
      const Vec3d pulled = node.free(U), met = obstacles.apply(pulled), taken = met - pulled;
      // What an obstacle holds follows its body nevertheless: the lock gives there.
      const Vec3d kept = dot(taken, taken) > 0 ? U : pulled;
      for (int a = 0; a < 3; ++a) own[k][a][i] = kept[a];
      sum = sum + node.mass * met;
      pulled_sum = pulled_sum + node.mass * pulled;
      mass += node.mass;
    }
    for (int a = 0; a < 3; ++a) {
      left[a][i] = sum[a] / mass;
      locked[a][i] = pulled_sum[a] / mass;
    }
  }
  if constexpr (kMeasure) measure_rigid_nodes(block, nodes, left, locked, held);
  double speed = 0;
  for (int a = 0; a < 3; ++a) {
    for (int i = 0; i < kBlockNodes; ++i) speed = std::max(speed, std::fabs(left[a][i]));
  }
  for_each_node_row(grid, [&](int r, size_t at) {
    for (size_t f = 0; f < fields_.size(); ++f) {
      if ((grid.bodies >> f & 1) == 0) continue;
      std::memset(fields_[f].momentum.data() + at, 0, kNodeRow * sizeof(T));
      if (kMeasure) std::memset(fields_[f].force_free.data() + at, 0, kNodeRow * sizeof(T));
      if (f > 0 && held) continue;
      T* const to = fields_[f].velocity.data() + kApart + at;
      for (int z = 0; z < kBlock; ++z) {
        to[4 * z] = 0;
        for (int a = 0; a < 3; ++a) to[4 * z + 1 + a] = T(left[a][kBlock * r + z]);
      }
    }
  });
  block.moments.assign(nodes.bodies, {});
  for (int k = 0; held && k < nodes.bodies; ++k) {
    rigid_detail::add_moments(nodes.mass[k], own[k][0], own[k][1], own[k][2], dx_, block.moments[k]);
  }
  return speed;
}

template <class T>
bool Grid<T>::update(double dt, bool fresh, RigidMotion& rigid, double& speed, std::vector<Vec3d>& push,
                     GridEnergy& energy) {
  const int bodies = rigid.count(), touched = static_cast<int>(rigid_blocks_.size());
  // Sums in the order of the blocks, whatever the threads.
  const auto add_up = [&](std::vector<NodeMoments>& sums) {
    sums.assign(bodies, {});
    for (const RigidBlock& r : rigid_blocks_) {
      const GridBlock& grid = map_.grid_blocks[r.index];
      const Vec3d first = {kBlock * grid.position[0] * dx_, kBlock * grid.position[1] * dx_,
                           kBlock * grid.position[2] * dx_};
      int k = 0;
      for (unsigned left = grid.bodies >> 1; left != 0; left &= left - 1, ++k) {
        const int body = __builtin_ctz(left);
        sums[body].add(r.moments[k], first - rigid.body(body).center);
      }
    }
  };
  if (rigid.held()) {
    team_.for_each(touched, [&](int r) { collect(rigid_blocks_[r], rigid_nodes_[r], dt, rigid); });
    add_up(rigid_system_.free);
    rigid_system_.held.clear();
    rigid_system_.pairs.clear();
    for (const RigidBlock& r : rigid_blocks_) {
      rigid_system_.held.insert(rigid_system_.held.end(), r.held.begin(), r.held.end());
      rigid_system_.pairs.insert(rigid_system_.pairs.end(), r.pairs.begin(), r.pairs.end());
    }
    if (!rigid.solve(dt, rigid_system_, fresh)) return false;
  }
  const int count = static_cast<int>(map_.grid_blocks.size());
  const auto update = [&](int b) {
    if (rigid_block_of_[b] >= 0) {
      const int r = rigid_block_of_[b];
      return setup_.measure_steps ? update_rigid_block<true>(rigid_blocks_[r], rigid_nodes_[r], dt, rigid)
                                  : update_rigid_block<false>(rigid_blocks_[r], rigid_nodes_[r], dt, rigid);
    }
    return setup_.measure_steps ? update_block<true, false>(b, dt) : update_block<false, false>(b, dt);
  };
  team_.for_each(chunk_bounds_, [&](int chunk) {
    for (int b = chunk * kChunk; b < std::min(count, (chunk + 1) * kChunk); ++b) speed_[b] = update(b);
  });
  speed = 0;
  for (const double s : speed_) speed = std::max(speed, s);
  if (setup_.measure_steps) {
    for (const GridEnergy& e : energy_) energy.add(e);
  }
  if (rigid.held()) {
    add_up(rigid_system_.free);
    rigid.finish(dt, rigid_system_.free);
    for (int b = 0; b < bodies; ++b) speed = std::max(speed, rigid.speed_bound(b));
    return true;
  }
  push.resize(bodies, {0, 0, 0});
  for (const RigidBlock& r : rigid_blocks_) {
    int k = 0;
    for (unsigned left = map_.grid_blocks[r.index].bodies >> 1; left != 0; left &= left - 1) {
      Vec3d& sum = push[__builtin_ctz(left)];
      sum = sum + r.push[k++];
    }
  }
  return true;
}

}  // namespace physmas::mpm

#endif
