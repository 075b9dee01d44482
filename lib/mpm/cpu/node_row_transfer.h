// Transfers of one particle, vectorised over the nodes of its stencil.
#ifndef PHYSMAS_MPM_CPU_NODE_ROW_TRANSFER_H
#define PHYSMAS_MPM_CPU_NODE_ROW_TRANSFER_H

#include <cstddef>

#include "mpm/cpu/blocks.h"
#include "mpm/cpu/node_row.h"

namespace physmas::mpm {

// Numbers from a node to its neighbour along x and y.
struct NodeSteps {
  std::ptrdiff_t x, y;
};

// Nine NodeRows of one particle's stencil, contracted one axis at a time. Results: velocity and the first moments
// Σ w v (node − centre node) along x, y and z in cells, four numbers each, the first of them without meaning.
template <class T>
PHYSMAS_INLINE NodeRow<T> z_weights(const T* wz) {
  using R = NodeRow<T>;
  return wz[0] * R::template unit<0>() + (wz[1] * R::template unit<1>() + wz[2] * R::template unit<2>());
}

// Nodes counted from the centre node along z.
template <class T>
PHYSMAS_INLINE NodeRow<T> z_steps() {
  return NodeRow<T>::template unit<2>() - NodeRow<T>::template unit<0>();
}

template <class T>
PHYSMAS_INLINE void gather_particle(const T* corner, const NodeSteps& step, const T* wx, const T* wy, const T* wz,
                                    T* out) {
  using R = NodeRow<T>;
  R sum[3], slope[3];
  for (int i = 0; i < 3; ++i) {
    const T* nodes = corner + i * step.x;
    const R low = rounded(wy[0] * R::load(nodes)), last = R::load(nodes + 2 * step.y);
    sum[i] = wy[2] * last + (wy[1] * R::load(nodes + step.y) + low);
    slope[i] = wy[2] * last - low;
  }
  const R low = rounded(wx[0] * sum[0]);
  const R weight = z_weights(wz);
  const R total = (wx[2] * sum[2] + (wx[1] * sum[1] + low)) * weight;
  const R along_x = (wx[2] * sum[2] - low) * weight;
  const R along_y = (wx[0] * slope[0] + wx[1] * slope[1] + wx[2] * slope[2]) * weight;
  const R along_z = total * z_steps<T>();
  R::sums_of_nodes(total, along_x, along_y, along_z).store(out);
}

// NodeRows begin at every other node, so that particles of two neighbouring cells along z share them; at the
// ends of a block's reach they begin where they do not leave it. The first node of such a NodeRow, for stencils from
// base on.
template <class V>
PHYSMAS_INLINE V node_row_start(const V& base) {
  using T = Scalar<V>;
  return at_most(at_least(T(2) * round_down(T(0.5) * base), V(T(-1))), V(T(kBlock - 1)));
}

// NodeRows with 1 in the four numbers of one node, 0 to 3, and 0 elsewhere.
template <class T>
struct NodeUnits {
  alignas(64) T number[4][16];
  constexpr NodeUnits() : number{} {
    for (int k = 0; k < 4; ++k) {
      for (int c = 0; c < 4; ++c) number[k][4 * k + c] = 1;
    }
  }
};
template <class T>
constexpr NodeUnits<T> kNodeUnits;

// P2G (paper, Eq. p2g): adds w (P + Q (node − centre node)) to the sums of nine NodeRows. record: {m, P}, and the
// columns of Q, four numbers each. later: nodes of the NodeRow before the particle's own, 0 or 1; without a branch,
// since no one could foretell it. wxy: products of the weights along x and y, a register's lanes apart.
template <class T>
PHYSMAS_INLINE void scatter_particle(NodeRow<T>* sum, int later, const T* wxy, const T* wz, const T* record) {
  using R = NodeRow<T>;
  constexpr int W = kLanes<T>;
  const T(*const unit)[16] = kNodeUnits<T>.number + later;
  const R first = R::load(unit[0]), last = R::load(unit[2]);
  const R weight = wz[0] * first + (wz[W] * R::load(unit[1]) + wz[2 * W] * last);
  const R all = R::load(record);
  const R center = (all.template repeat<0>() + (last - first) * all.template repeat<3>()) * weight;
  const R x = all.template repeat<1>() * weight, y = all.template repeat<2>() * weight;
  const R plane[3] = {center - x, center, center + x};
  for (int i = 0; i < 3; ++i) {
    sum[3 * i] = wxy[3 * i * W] * (plane[i] - y) + sum[3 * i];
    sum[3 * i + 1] = wxy[(3 * i + 1) * W] * plane[i] + sum[3 * i + 1];
    sum[3 * i + 2] = wxy[(3 * i + 2) * W] * (plane[i] + y) + sum[3 * i + 2];
  }
}

template <class T>
PHYSMAS_INLINE void add_node_rows(const NodeRow<T>* sum, T* corner, const NodeSteps& step) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      T* nodes = corner + i * step.x + j * step.y;
      (NodeRow<T>::load(nodes) + sum[3 * i + j]).store(nodes);
    }
  }
}

}  // namespace physmas::mpm

#endif
