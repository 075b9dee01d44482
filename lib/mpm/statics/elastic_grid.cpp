#include "mpm/statics/elastic_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace physmas::mpm::statics {

namespace {

// Points are worked off in blocks of 4×4×4 cells. Blocks of one colour are apart by another block, so their stencils
// share no node: they may be added to the nodes at a time, and the order of sums is that of the blocks.
constexpr int kBlock = 4;

struct Cell {
  int i, j, k;  // first node of the stencils
};

Cell cell_of(const Vec3d& x, double inverse_dx) {
  const auto first = [&](double a) { return static_cast<int>(std::floor(a * inverse_dx - 0.5)); };
  return {first(x.x), first(x.y), first(x.z)};
}

int color_of(const Cell& c) {
  return (c.i / kBlock % 2) * 4 + (c.j / kBlock % 2) * 2 + c.k / kBlock % 2;
}

// Which nodes are there, a bit each, and how many come before.
class NodeSet {
 public:
  explicit NodeSet(int nodes)
      : nodes_(nodes), bits_((static_cast<size_t>(nodes) * nodes * nodes + 63) / 64), before_(bits_.size()) {}
  void insert(int i, int j, int k) {
    const size_t flat = flat_of(i, j, k);
    bits_[flat / 64] |= std::uint64_t(1) << (flat % 64);
  }
  void count() {
    int sum = 0;
    for (size_t w = 0; w < bits_.size(); ++w) {
      before_[w] = sum;
      sum += __builtin_popcountll(bits_[w]);
    }
    total_ = sum;
  }
  int number(int i, int j, int k) const {
    const size_t flat = flat_of(i, j, k);
    return before_[flat / 64] + __builtin_popcountll(bits_[flat / 64] & ((std::uint64_t(1) << (flat % 64)) - 1));
  }
  std::vector<std::array<int, 3>> places() const {
    std::vector<std::array<int, 3>> list;
    list.reserve(total_);
    for (size_t w = 0; w < bits_.size(); ++w) {
      for (std::uint64_t rest = bits_[w]; rest != 0; rest &= rest - 1) {
        const size_t flat = w * 64 + __builtin_ctzll(rest);
        list.push_back({static_cast<int>(flat / (static_cast<size_t>(nodes_) * nodes_)),
                        static_cast<int>(flat / nodes_ % nodes_), static_cast<int>(flat % nodes_)});
      }
    }
    return list;
  }

 private:
  size_t flat_of(int i, int j, int k) const { return (static_cast<size_t>(i) * nodes_ + j) * nodes_ + k; }
  int nodes_, total_ = 0;
  std::vector<std::uint64_t> bits_;
  std::vector<int> before_;
};

int root_of(std::vector<int>& parent, int node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

}  // namespace

ElasticGrid::ElasticGrid(const Domain& domain, const Particles& particles, const std::vector<int>& chosen,
                         const std::vector<MaterialParameters<double>>& parameters, Team& team)
    : gradient_(4 / domain.dx()), team_(team) {
  const double inverse_dx = 1 / domain.dx();
  // Colour, block, cell, particle: the order of all sums.
  struct Key {
    int color, block, cell, particle;
    Cell at;
  };
  const int blocks = domain.n / kBlock + 1;
  std::vector<Key> keys;
  keys.reserve(chosen.size());
  NodeSet nodes(domain.n + 1);
  for (const int q : chosen) {
    // As the solver does with what is outside of the safe interior: two cells from the boundary.
    Vec3d x = particles.position[q];
    for (int a = 0; a < 3; ++a) x[a] = std::min(std::max(x[a], 2 * domain.dx()), domain.length - 2 * domain.dx());
    const Cell c = cell_of(x, inverse_dx);
    const int block = (c.i / kBlock * blocks + c.j / kBlock) * blocks + c.k / kBlock;
    const int cell = (c.i % kBlock * kBlock + c.j % kBlock) * kBlock + c.k % kBlock;
    keys.push_back({color_of(c), block, cell, q, c});
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) nodes.insert(c.i + i, c.j + j, c.k + k);
  }
  nodes.count();
  place_ = nodes.places();
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return std::tie(a.color, a.block, a.cell, a.particle) < std::tie(b.color, b.block, b.cell, b.particle);
  });
  points_.reserve(keys.size());
  int color = -1;
  for (size_t p = 0; p < keys.size(); ++p) {
    const Key& key = keys[p];
    const bool first = p == 0 || key.color != keys[p - 1].color || key.block != keys[p - 1].block;
    if (first) {
      while (color < key.color) color_begin_[++color] = static_cast<int>(block_begin_.size());
      block_begin_.push_back(static_cast<int>(p));
    }
    if (first || key.cell != keys[p - 1].cell) {
      Columns columns;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) columns[3 * i + j] = nodes.number(key.at.i + i, key.at.j + j, key.at.k);
      columns_.push_back(columns);
    }
    const int q = key.particle;
    MaterialParameters<double> m = parameters[particles.row[q]];
    if (!particles.material.empty()) m = with_elasticity(m, elasticity_of(particles.material[q]));
    const Vec3d cells = inverse_dx * particles.position[q];
    Point point;
    point.at = {cells.x - key.at.i, cells.y - key.at.j, cells.z - key.at.k};
    for (int a = 0; a < 3; ++a) point.at[a] = std::min(std::max(point.at[a], 0.5), 1.5);
    point.volume = particles.volume[q];
    point.row_mu = point.mu = m.mu;
    point.row_bulk = m.bulk;
    point.lambda = m.lambda;
    point.mass = m.density * point.volume;
    point.particle = q;
    point.row = particles.row[q];
    point.cell = static_cast<int>(columns_.size()) - 1;
    points_.push_back(point);
  }
  while (color < 8) color_begin_[++color] = static_cast<int>(block_begin_.size());
  block_begin_.push_back(static_cast<int>(points_.size()));

  mass_ = scatter_mass(std::vector<double>(size(), 1.0));
}

// function(first point, end) for all blocks, at most one block at a time for every node.
template <class Function>
void ElasticGrid::for_each_block(const Function& function) const {
  for (int color = 0; color < 8; ++color) {
    const int first = color_begin_[color], count = color_begin_[color + 1] - first;
    team_.for_each(count, [&](int b) { function(block_begin_[first + b], block_begin_[first + b + 1]); });
  }
}

// u: gathered to a symmetric gradient per point when given. stress(point, ε): what is scattered to `force`, when given.
template <class Stress>
void ElasticGrid::gather_scatter(const NodeField* u, NodeField* force, const Stress& stress) const {
  if (force) {
    const Vec4 none = {0, 0, 0, 0};
    force->assign(node_count(), none);
  }
  for_each_block([&](int begin, int end) {
    for (int q = begin; q < end; ++q) {
      const Point& p = points_[q];
      const Columns& columns = columns_[p.cell];
      const Weights x(p.at.x), y(p.at.y), z(p.at.z);
      const double zd[3] = {z.w[0] * z.offset[0], z.w[1] * z.offset[1], z.w[2] * z.offset[2]};
      // Columns of the gradient: Gx holds the derivatives of all components along x.
      Vec4 Gx = {0, 0, 0, 0}, Gy = Gx, Gz = Gx;
      if (u) {
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            const Vec4* at = u->data() + columns[3 * i + j];
            const double w = x.w[i] * y.w[j];
            const Vec4 sum = z.w[0] * at[0] + z.w[1] * at[1] + z.w[2] * at[2];
            Gx += (w * x.offset[i]) * sum;
            Gy += (w * y.offset[j]) * sum;
            Gz += w * (zd[0] * at[0] + zd[1] * at[1] + zd[2] * at[2]);
          }
        }
      }
      const double g = gradient_, h = 0.5 * gradient_;
      const Symmetric<double> tau = stress(q, Symmetric<double>{g * Gx[0], g * Gy[1], g * Gz[2], h * (Gx[1] + Gy[0]),
                                                                h * (Gx[2] + Gz[0]), h * (Gy[2] + Gz[1])});
      if (!force) continue;
      const double s = p.volume * gradient_;
      const Vec4 tx = {s * tau.xx, s * tau.xy, s * tau.xz, 0}, ty = {s * tau.xy, s * tau.yy, s * tau.yz, 0},
                 tz = {s * tau.xz, s * tau.yz, s * tau.zz, 0};
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          Vec4* at = force->data() + columns[3 * i + j];
          const double w = x.w[i] * y.w[j];
          const Vec4 flat = (w * x.offset[i]) * tx + (w * y.offset[j]) * ty, along = w * tz;
          for (int k = 0; k < 3; ++k) at[k] += z.w[k] * flat + zd[k] * along;
        }
      }
    }
  });
}

void ElasticGrid::strains(const NodeField& u, std::vector<Symmetric<double>>& strain) const {
  strain.resize(size());
  gather_scatter(&u, nullptr, [&](int q, const Symmetric<double>& e) { return strain[q] = e; });
}

void ElasticGrid::internal_forces(const std::vector<Symmetric<double>>& tau, NodeField& force) const {
  gather_scatter(nullptr, &force, [&](int q, const Symmetric<double>&) { return tau[q]; });
}

void ElasticGrid::stiffness(const NodeField& u, NodeField& force) const {
  gather_scatter(&u, &force, [&](int q, const Symmetric<double>& e) { return this->stress(q, e); });
}

std::vector<Symmetric<double>> ElasticGrid::diagonal() const {
  std::vector<Symmetric<double>> blocks(node_count(), Symmetric<double>{0, 0, 0, 0, 0, 0});
  for_each_block([&](int begin, int end) {
    for (int q = begin; q < end; ++q) {
      const Point& p = points_[q];
      for_each_node(q, [&](int node, double w, const Vec3d& offset) {
        // V ((λ + μ) g gᵀ + μ |g|² I).
        const Vec3d g = (w * gradient_) * offset;
        const double outer = p.volume * (p.lambda + p.mu), own = p.volume * p.mu * dot(g, g);
        Symmetric<double>& b = blocks[node];
        b.xx += outer * g.x * g.x + own, b.yy += outer * g.y * g.y + own, b.zz += outer * g.z * g.z + own;
        b.xy += outer * g.x * g.y, b.xz += outer * g.x * g.z, b.yz += outer * g.y * g.z;
      });
    }
  });
  return blocks;
}

std::vector<double> ElasticGrid::gather(const std::vector<double>& value) const {
  std::vector<double> out(size(), 0.0);
  for (size_t q = 0; q < size(); ++q)
    for_each_node(q, [&](int node, double w, const Vec3d&) { out[q] += w * value[node]; });
  return out;
}

std::vector<Vec3d> ElasticGrid::gather(const NodeField& value) const {
  std::vector<Vec3d> out(size(), Vec3d{0, 0, 0});
  for (size_t q = 0; q < size(); ++q)
    for_each_node(q, [&](int node, double w, const Vec3d&) { out[q] = out[q] + w * to_vec3(value[node]); });
  return out;
}

std::vector<double> ElasticGrid::scatter_mass(const std::vector<double>& share) const {
  std::vector<double> mass(node_count(), 0.0);
  for (size_t q = 0; q < size(); ++q) {
    const Point& p = points_[q];
    for_each_node(q, [&](int node, double w, const Vec3d&) { mass[node] += w * p.mass * share[q]; });
  }
  return mass;
}

std::vector<int> ElasticGrid::components(int& count) const {
  std::vector<int> parent(node_count());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Columns& columns : columns_) {
    const int first = root_of(parent, columns[0]);
    for (const int column : columns)
      for (int k = 0; k < 3; ++k) parent[root_of(parent, column + k)] = first;
  }
  count = 0;
  std::vector<int> number(node_count(), -1), component(node_count());
  for (size_t a = 0; a < node_count(); ++a) {
    int& mine = number[root_of(parent, static_cast<int>(a))];
    if (mine < 0) mine = count++;
    component[a] = mine;
  }
  return component;
}

}  // namespace physmas::mpm::statics
