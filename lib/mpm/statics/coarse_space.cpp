#include "mpm/statics/coarse_space.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace physmas::mpm::statics {

namespace {

constexpr int kMostBodies = 3000;

using Block = Eigen::Matrix<double, 6, 6>;

// How the gradient at a particle follows from the six motions of a body: three along the axes, three about them.
struct BodyGradient {
  int body = -1;
  Vec3d sum = {0, 0, 0};  // Σ weight ∇w over the nodes
  Mat3d moment = {};      // Σ weight arm ∇wᵀ
  std::array<Symmetric<double>, 6> strain;

  void add(double weight, const Vec3d& arm, const Vec3d& gradient) {
    sum = sum + weight * gradient;
    for (int i = 0; i < 3; ++i) moment[i] = moment[i] + (weight * arm[i]) * gradient;
  }
  void find_strains() {
    for (int m = 0; m < 6; ++m) {
      Mat3d G = {};  // ∇u
      const int a = m % 3, b = (a + 1) % 3, c = (a + 2) % 3;
      if (m < 3) {
        G[a] = sum;
      } else {  // e_a × arm
        G[b] = -moment[c];
        G[c] = moment[b];
      }
      strain[m] = {G[0].x, G[1].y, G[2].z, 0.5 * (G[0].y + G[1].x), 0.5 * (G[0].z + G[2].x), 0.5 * (G[1].z + G[2].y)};
    }
  }
};

double product(const Symmetric<double>& a, const Symmetric<double>& b) {
  return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2 * (a.xy * b.xy + a.xz * b.xz + a.yz * b.yz);
}

}  // namespace

CoarseSpace::CoarseSpace(const ElasticGrid& grid, const Supports& supports, const std::vector<double>& spring) {
  for (size_t a = 0; a < grid.node_count(); ++a) {
    const std::array<int, 3>& p = grid.place(a);
    node_place_.push_back({double(p[0]), double(p[1]), double(p[2])});
  }
  do {
    find_bodies(grid, supports);
    size_ *= 2;
  } while (center_.size() > kMostBodies);
  size_ /= 2;
  factorise(grid, spring);
}

void CoarseSpace::find_bodies(const ElasticGrid& grid, const Supports& supports) {
  std::map<std::tuple<int, int, int, int>, int> number;
  std::vector<int> body(grid.size());
  center_.clear();
  for (size_t p = 0; p < grid.size(); ++p) {
    const std::array<int, 3>& cell = grid.place(grid.any_node(p));
    const auto key = std::make_tuple(cell[0] / size_, cell[1] / size_, cell[2] / size_, grid.row(p));
    const auto [it, fresh] = number.try_emplace(key, static_cast<int>(number.size()));
    body[p] = it->second;
    if (!fresh) continue;
    Vec3d middle;
    for (int a = 0; a < 3; ++a) middle[a] = (cell[a] / size_ + 0.5) * size_ + 1;
    center_.push_back(middle);
  }
  std::vector<std::vector<Share>> of_node(grid.node_count());
  for (size_t p = 0; p < grid.size(); ++p) {
    grid.for_each_node(p, [&](int node, double w, const Vec3d&) {
      const double weight = w * grid.stiffness_weight(p);
      if (!(weight > 0) || supports.touches(node)) return;
      std::vector<Share>& list = of_node[node];
      const auto it = std::find_if(list.begin(), list.end(), [&](const Share& s) { return s.body == body[p]; });
      if (it == list.end())
        list.push_back({body[p], weight});
      else
        it->weight += weight;
    });
  }
  shares_.clear();
  share_begin_.assign(1, 0);
  for (std::vector<Share>& list : of_node) {
    std::sort(list.begin(), list.end(), [](const Share& a, const Share& b) { return a.body < b.body; });
    double sum = 0;
    for (const Share& s : list) sum += s.weight;
    for (const Share& s : list) shares_.push_back({s.body, s.weight / sum});
    share_begin_.push_back(static_cast<int>(shares_.size()));
  }
}

void CoarseSpace::factorise(const ElasticGrid& grid, const std::vector<double>& spring) {
  // Blocks of the upper triangle by (row, column).
  std::map<std::pair<int, int>, Block> blocks;
  for (size_t g = 0; g < center_.size(); ++g) blocks[{g, g}] = Block::Zero();
  const auto block_of = [&](int g, int h) -> Block& {
    const auto [it, fresh] = blocks.try_emplace({g, h});
    if (fresh) it->second.setZero();
    return it->second;
  };
  std::vector<BodyGradient> here;
  for (size_t p = 0; p < grid.size(); ++p) {
    here.clear();
    grid.for_each_node(p, [&](int node, double w, const Vec3d& offset) {
      const Vec3d gradient = (w * grid.gradient()) * offset;
      for (int s = share_begin_[node]; s < share_begin_[node + 1]; ++s) {
        const Share& share = shares_[s];
        auto it = std::find_if(here.begin(), here.end(), [&](const BodyGradient& b) { return b.body == share.body; });
        if (it == here.end()) {
          here.emplace_back();
          it = here.end() - 1;
          it->body = share.body;
        }
        it->add(share.weight, arm(share.body, node), gradient);
      }
    });
    std::sort(here.begin(), here.end(), [](const BodyGradient& a, const BodyGradient& b) { return a.body < b.body; });
    for (BodyGradient& b : here) b.find_strains();
    for (size_t i = 0; i < here.size(); ++i) {
      std::array<Symmetric<double>, 6> stress;
      for (int m = 0; m < 6; ++m) stress[m] = grid.stress(p, here[i].strain[m]);
      for (size_t j = i; j < here.size(); ++j) {
        Block& block = block_of(here[i].body, here[j].body);
        for (int m = 0; m < 6; ++m)
          for (int n = 0; n < 6; ++n) block(m, n) += grid.volume(p) * product(stress[m], here[j].strain[n]);
      }
    }
  }
  const auto motion = [](int m, const Vec3d& arm) {
    Vec3d u = {0, 0, 0};
    const int a = m % 3;
    if (m < 3)
      u[a] = 1;
    else
      u[(a + 1) % 3] = -arm[(a + 2) % 3], u[(a + 2) % 3] = arm[(a + 1) % 3];
    return u;
  };
  for (size_t node = 0; node < grid.node_count(); ++node) {
    for (int s = share_begin_[node]; s < share_begin_[node + 1]; ++s) {
      for (int t = s; t < share_begin_[node + 1]; ++t) {
        Block& block = block_of(shares_[s].body, shares_[t].body);
        const double scale = spring[node] * shares_[s].weight * shares_[t].weight;
        const Vec3d first = arm(shares_[s].body, node), second = arm(shares_[t].body, node);
        for (int m = 0; m < 6; ++m)
          for (int n = 0; n < 6; ++n) block(m, n) += scale * dot(motion(m, first), motion(n, second));
      }
    }
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (auto& [key, block] : blocks) {
    const auto [g, h] = key;
    if (g == h) {
      // Bodies whose nodes are all held have no stiffness of their own.
      const double mean = block.trace() / kModes;
      for (int m = 0; m < kModes; ++m) block(m, m) += 1e-10 * mean + (mean > 0 ? 0 : 1);
    }
    for (int m = 0; m < kModes; ++m) {
      for (int n = 0; n < kModes; ++n) {
        const int i = g * kModes + m, j = h * kModes + n;
        if (i <= j) entries.emplace_back(j, i, block(m, n));  // the lower triangle is what is read
      }
    }
  }
  const int size = static_cast<int>(center_.size()) * kModes;
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  factor_.compute(matrix);
}

void CoarseSpace::add_solution(const NodeField& r, NodeField& z) const {
  if (factor_.info() != Eigen::Success) return;
  Eigen::VectorXd seen = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(center_.size()) * kModes);
  for (size_t node = 0; node < r.size(); ++node) {
    const Vec3d f = to_vec3(r[node]);
    for (int s = share_begin_[node]; s < share_begin_[node + 1]; ++s) {
      const int body = shares_[s].body;
      const Vec3d turn = cross(arm(body, node), f);
      double* out = seen.data() + body * kModes;
      for (int a = 0; a < 3; ++a) {
        out[a] += shares_[s].weight * f[a];
        out[3 + a] += shares_[s].weight * turn[a];
      }
    }
  }
  const Eigen::VectorXd motion = factor_.solve(seen);
  for (size_t node = 0; node < r.size(); ++node) {
    Vec3d u = {0, 0, 0};
    for (int s = share_begin_[node]; s < share_begin_[node + 1]; ++s) {
      const int body = shares_[s].body;
      const double* m = motion.data() + body * kModes;
      u = u + shares_[s].weight * (Vec3d{m[0], m[1], m[2]} + cross(Vec3d{m[3], m[4], m[5]}, arm(body, node)));
    }
    z[node] += to_vec4(u);
  }
}

}  // namespace physmas::mpm::statics
