#include "lift/agreement.h"

#include <algorithm>

namespace physmas::lift {
namespace {

// The share of Gaussians on which two views agree, of those that both see inside a mask; -1 where that is not known.
double agreement_of(const ViewMasks& a, const ViewMasks& b, const std::vector<int32_t>& in_a,
                    const std::vector<int32_t>& in_b) {
  long shared = 0, agreed = 0;
  for (size_t i = 0; i < in_a.size(); ++i) {
    if (in_a[i] < 0 || in_b[i] < 0) continue;
    bool by_a = false, by_b = false, by_both = false;
    for (size_t r = 0; r < a.rows.size(); ++r) {
      const bool covers_a = !a.rows[r].empty() && a.rows[r].pixels[in_a[i]] != 0;
      const bool covers_b = !b.rows[r].empty() && b.rows[r].pixels[in_b[i]] != 0;
      by_a = by_a || covers_a;
      by_b = by_b || covers_b;
      by_both = by_both || (covers_a && covers_b);
    }
    if (!by_a || !by_b) continue;
    ++shared;
    agreed += by_both;
  }
  return shared < kSharedLeast ? -1 : static_cast<double>(agreed) / static_cast<double>(shared);
}

}  // namespace

Agreement compare_views(const std::vector<ViewMasks>& views, const std::vector<std::vector<int32_t>>& pixels) {
  const size_t n = views.size();
  std::vector<std::vector<double>> agreement(n, std::vector<double>(n, -1));
  for (size_t v = 0; v < n; ++v) {
    for (size_t w = v + 1; w < n; ++w)
      agreement[v][w] = agreement[w][v] = agreement_of(views[v], views[w], pixels[v], pixels[w]);
  }
  Agreement found;
  for (size_t v = 0; v < n; ++v) {
    int known = 0, against = 0, pairs = 0, agreeing = 0;
    for (size_t w = 0; w < n; ++w) {
      if (w == v || agreement[v][w] < 0) continue;
      ++known;
      against += agreement[v][w] < kContradiction;
      for (size_t x = w + 1; x < n; ++x) {
        if (x == v || agreement[w][x] < 0) continue;
        ++pairs;
        agreeing += agreement[w][x] >= kAgreement;
      }
    }
    if (known >= 2 && against == known && 2 * agreeing > pairs) found.contradicted.push_back(v);
  }
  const auto counts = [&](size_t v) {
    return std::find(found.contradicted.begin(), found.contradicted.end(), v) == found.contradicted.end();
  };
  for (size_t v = 0; v < n; ++v) {
    for (size_t w = v + 1; w < n; ++w) {
      if (agreement[v][w] >= 0 && agreement[v][w] < kContradiction && counts(v) && counts(w))
        found.undecided.emplace_back(v, w);
    }
  }
  return found;
}

}  // namespace physmas::lift
