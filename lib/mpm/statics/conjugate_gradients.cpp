#include "mpm/statics/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

namespace physmas::mpm::statics {

namespace {

constexpr int kRange = 2048;  // nodes that one sum runs over; the sums are added in their order

Symmetric<double> inverse(const Symmetric<double>& a) {
  const double xx = a.yy * a.zz - a.yz * a.yz, xy = a.xz * a.yz - a.xy * a.zz, xz = a.xy * a.yz - a.yy * a.xz;
  const double s = 1 / (a.xx * xx + a.xy * xy + a.xz * xz);
  return {s * xx, s * (a.xx * a.zz - a.xz * a.xz), s * (a.xx * a.yy - a.xy * a.xy), s * xy,
          s * xz, s * (a.xy * a.xz - a.xx * a.yz)};
}

std::vector<double> springs_of(const ElasticGrid& grid) {
  std::vector<double> spring;
  for (const double mass : grid.mass()) spring.push_back(mass / (kPatience * kPatience));
  return spring;
}

}  // namespace

ConjugateGradients::ConjugateGradients(const ElasticGrid& grid, const Supports& supports, Team& team)
    : grid_(grid),
      team_(team),
      spring_(springs_of(grid)),
      inverse_block_(grid.diagonal()),
      coarse_(grid, supports, spring_) {
  double largest = 0;
  for (const Symmetric<double>& b : inverse_block_) largest = std::max(largest, trace(b));
  for (size_t a = 0; a < grid.node_count(); ++a) {
    Symmetric<double>& b = inverse_block_[a];
    const double mean = trace(b) / 3;
    if (!(mean > 1e-20 * largest)) {
      b = {0, 0, 0, 0, 0, 0};  // at the very edge of a stencil there is next to nothing
      continue;
    }
    const double rounding = 1e-3 * mean + spring_[a];  // the block of one particle may be flat
    b.xx += rounding, b.yy += rounding, b.zz += rounding;
    b = inverse(b);
  }
}

template <class Work>
void ConjugateGradients::for_each_range(const Work& work) const {
  const int count = static_cast<int>(grid_.node_count()), ranges = (count + kRange - 1) / kRange;
  team_.for_each(ranges, [&](int r) { work(r, r * kRange, std::min(count, (r + 1) * kRange)); });
}

double ConjugateGradients::dot(const NodeField& a, const NodeField& b) const {
  std::vector<double> partial(grid_.node_count() / kRange + 1, 0.0);
  for_each_range([&](int range, int begin, int end) {
    Vec4 sum = {0, 0, 0, 0};
    for (int n = begin; n < end; ++n) sum += a[n] * b[n];
    partial[range] = sum[0] + sum[1] + sum[2];
  });
  double total = 0;
  for (const double p : partial) total += p;
  return total;
}

void ConjugateGradients::precondition(const Supports& supports, const NodeField& r, NodeField& z) const {
  z.resize(r.size());
  for_each_range([&](int, int begin, int end) {
    for (int n = begin; n < end; ++n) {
      const Symmetric<double>& b = inverse_block_[n];
      const Vec4 f = r[n];
      z[n] = f[0] * Vec4{b.xx, b.xy, b.xz, 0} + f[1] * Vec4{b.xy, b.yy, b.yz, 0} + f[2] * Vec4{b.xz, b.yz, b.zz, 0};
    }
  });
  coarse_.add_solution(r, z);
  supports.project(z);
}

double ConjugateGradients::size(const Supports& supports, const NodeField& force) const {
  NodeField z;
  precondition(supports, force, z);
  return std::sqrt(std::max(0.0, dot(force, z)));
}

void ConjugateGradients::add_springs(const NodeField& u, NodeField& force) const {
  for_each_range([&](int, int begin, int end) {
    for (int n = begin; n < end; ++n) force[n] += spring_[n] * u[n];
  });
}

int ConjugateGradients::solve(const Supports& supports, const NodeField& force, double tolerance, int most,
                              NodeField& u) const {
  NodeField r = force, z, p, Kp;
  supports.project(r);
  precondition(supports, r, z);
  p = z;
  double rz = dot(r, z);
  int iterations = 0;
  while (iterations < most && rz > tolerance * tolerance) {
    grid_.stiffness(p, Kp);
    add_springs(p, Kp);
    supports.project(Kp);
    const double curvature = dot(p, Kp);
    if (!(curvature > 0)) break;
    const double alpha = rz / curvature;
    for_each_range([&](int, int begin, int end) {
      for (int n = begin; n < end; ++n) {
        u[n] += alpha * p[n];
        r[n] -= alpha * Kp[n];
      }
    });
    precondition(supports, r, z);
    const double next = dot(r, z), beta = next / rz;
    rz = next;
    for_each_range([&](int, int begin, int end) {
      for (int n = begin; n < end; ++n) p[n] = z[n] + beta * p[n];
    });
    ++iterations;
  }
  return iterations;
}

}  // namespace physmas::mpm::statics
