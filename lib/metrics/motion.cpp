#include "metrics/motion.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace physmas::metrics {
namespace {

Measurement invalid(const std::string& reason) {
  Measurement m;
  m.reason = reason;
  return m;
}

std::string shape_mismatch(const Tracks& a, const Tracks& b) {
  if (a.frames() != b.frames())
    return fmt::format("{} predicted frames against {} of the reference", b.frames(), a.frames());
  if (a.points() != b.points())
    return fmt::format("{} predicted points against {} of the reference", b.points(), a.points());
  if (a.frames() == 0 || a.points() == 0) return "no tracked points";
  if (a.width != b.width || a.height != b.height)
    return fmt::format("a video of {} x {} pixels against {} x {} of the reference", b.width, b.height, a.width,
                       a.height);
  return "";
}

bool measured(const Tracks& tracks, size_t t, size_t i) {
  return tracks.visible[t][i] != 0 && tracks.position[t][i].allFinite();
}

// A pair counts when both videos show the point in that frame and in frame 0: one that is hidden in frame 0 was never
// initialised.
bool jointly_measured(const Tracks& a, const Tracks& b, size_t t, size_t i) {
  return measured(a, t, i) && measured(b, t, i) && measured(a, 0, i) && measured(b, 0, i);
}

// Jointly visible points of each frame; empty where they are fewer than kMinimumPoints.
std::vector<std::vector<int>> joint_points(const Tracks& a, const Tracks& b) {
  std::vector<std::vector<int>> joint(a.frames());
  for (size_t t = 0; t < a.frames(); ++t) {
    for (size_t i = 0; i < a.points(); ++i) {
      if (jointly_measured(a, b, t, i)) joint[t].push_back(static_cast<int>(i));
    }
    if (static_cast<int>(joint[t].size()) < kMinimumPoints) joint[t].clear();
  }
  return joint;
}

// The kNeighbours nearest points of frame 0, ties by index.
std::vector<std::vector<int>> neighbour_graph(const Tracks& reference) {
  const std::vector<Eigen::Vector2d>& points = reference.position[0];
  std::vector<std::vector<int>> graph(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    if (!measured(reference, 0, i)) continue;
    std::vector<int> others;
    for (size_t j = 0; j < points.size(); ++j) {
      if (j != i && measured(reference, 0, j)) others.push_back(static_cast<int>(j));
    }
    std::stable_sort(others.begin(), others.end(), [&](int a, int b) {
      return (points[a] - points[i]).squaredNorm() < (points[b] - points[i]).squaredNorm();
    });
    if (others.size() > kNeighbours) others.resize(kNeighbours);
    graph[i] = others;
  }
  return graph;
}

// Least-squares F that maps rest offsets to current ones; nothing when the rest neighbourhood is degenerate.
std::optional<Eigen::Matrix2d> local_deformation(const Tracks& tracks, size_t t, int center,
                                                 const std::vector<int>& neighbours) {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero(), B = Eigen::Matrix2d::Zero();
  for (int j : neighbours) {
    const Eigen::Vector2d rest = tracks.position[0][j] - tracks.position[0][center];
    const Eigen::Vector2d now = tracks.position[t][j] - tracks.position[t][center];
    A += rest * rest.transpose();
    B += now * rest.transpose();
  }
  const Eigen::Vector2d eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(A).eigenvalues();
  if (!(eigenvalues[1] > 0) || !(eigenvalues[0] > kDegenerate * eigenvalues[1])) return std::nullopt;
  const Eigen::Matrix2d ridge = kRidge * 0.5 * eigenvalues.sum() * Eigen::Matrix2d::Identity();
  return Eigen::Matrix2d((B + ridge) * (A + ridge).inverse());
}

Measurement rmse(double sum, long samples) {
  // Finite positions can still be too far apart to be squared.
  if (!std::isfinite(sum)) return invalid("positions too large to compare");
  Measurement m;
  m.valid = true;
  m.samples = samples;
  m.value = 100 * std::sqrt(sum / static_cast<double>(samples));
  return m;
}

}  // namespace

Measurement trajectory_nrmse(const Tracks& reference, const Tracks& predicted) {
  const std::string mismatch = shape_mismatch(reference, predicted);
  if (!mismatch.empty()) return invalid(mismatch);
  double sum = 0;
  long pairs = 0;
  const std::vector<std::vector<int>> joint = joint_points(reference, predicted);
  for (size_t t = 0; t < joint.size(); ++t) {
    for (int i : joint[t]) {
      const Eigen::Vector2d d = predicted.position[t][i] - reference.position[t][i];
      sum += d.x() * d.x() / (double(reference.width) * reference.width) +
             d.y() * d.y() / (double(reference.height) * reference.height);
      ++pairs;
    }
  }
  if (pairs == 0) return invalid(fmt::format("no frame has {} jointly visible points", kMinimumPoints));
  return rmse(sum, pairs);
}

Measurement area_log_rmse(const std::vector<long>& reference, const std::vector<long>& predicted) {
  if (reference.size() != predicted.size())
    return invalid(fmt::format("{} predicted frames against {} of the reference", predicted.size(), reference.size()));
  if (reference.empty()) return invalid("no frames");
  if (reference[0] == 0) return invalid("the target is not seen in frame 0 of the reference");
  if (predicted[0] == 0) return invalid("the target is not seen in frame 0");
  double sum = 0;
  for (size_t t = 0; t < reference.size(); ++t) {
    const double d = std::log(static_cast<double>(predicted[t]) + 1) - std::log(static_cast<double>(reference[t]) + 1);
    sum += d * d;
  }
  return rmse(sum, static_cast<long>(reference.size()));
}

Measurement strain_rmse(const Tracks& reference, const Tracks& predicted) {
  const std::string mismatch = shape_mismatch(reference, predicted);
  if (!mismatch.empty()) return invalid(mismatch);
  const std::vector<std::vector<int>> graph = neighbour_graph(reference);
  double sum = 0;
  long samples = 0;
  for (size_t t = 0; t < reference.frames(); ++t) {
    const auto joint = [&](int i) { return jointly_measured(reference, predicted, t, i); };
    for (size_t i = 0; i < graph.size(); ++i) {
      if (!joint(static_cast<int>(i))) continue;
      std::vector<int> neighbours;
      std::copy_if(graph[i].begin(), graph[i].end(), std::back_inserter(neighbours), joint);
      if (static_cast<int>(neighbours.size()) < kMinimumNeighbours) continue;
      const auto F = local_deformation(reference, t, static_cast<int>(i), neighbours);
      const auto G = local_deformation(predicted, t, static_cast<int>(i), neighbours);
      if (!F || !G) continue;
      sum += (0.5 * (*G).transpose() * *G - 0.5 * (*F).transpose() * *F).squaredNorm();
      ++samples;
    }
  }
  if (samples == 0) return invalid("no jointly visible neighbourhood");
  return rmse(sum, samples);
}

}  // namespace physmas::metrics
