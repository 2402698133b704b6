// A batch as a message holds it.
#include "tests/bench/verbs/packed_columns.h"

#include <algorithm>
#include <cmath>

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;

template <class T>
bool all_equal(const std::vector<T>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(),
                     [&](const T& x) { return x == numbers.front(); });
}

}  // namespace

PackedColumns::PackedColumns(std::span<const Ray> rays, scenegraph::QueryKind kind) {
  for (const Ray& ray : rays) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      origins_.push_back(ray.origin[axis]);
      directions_.push_back(ray.direction[axis]);
    }
    tmin_.push_back(ray.tmin);
    tmax_.push_back(ray.tmax);
    masks_.push_back(ray.mask);
  }
  rays_.size = fields_.size = rays.size();
  rays_.origin = accel::geometry::columns_of_rows(origins_.data(), true);
  rays_.direction = accel::geometry::columns_of_rows(directions_.data(), true);
  rays_.tmin = {tmin_.data(), all_equal(tmin_) ? 0u : 1u, true};
  rays_.tmax = {tmax_.data(), all_equal(tmax_) ? 0u : 1u, true};
  rays_.mask = {masks_.data(), all_equal(masks_) ? 0u : 1u};
  if (kind == scenegraph::QueryKind::kAny) {
    bits_.resize((rays.size() + 7) / 8);
    fields_.bits = bits_.data();
    return;
  }
  t_.resize(rays.size());
  nodes_.resize(rays.size());
  primitives_.resize(rays.size());
  fields_.t.data = t_.data();
  fields_.node.data = nodes_.data();
  fields_.primitive.data = primitives_.data();
}

std::vector<Hit> PackedColumns::hits() const {
  std::vector<Hit> hits(rays_.size);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    Hit& hit = hits[i];
    if (!bits_.empty()) {
      hit.state = (bits_[i / 8] >> i % 8 & 1) != 0 ? HitState::kHit : HitState::kMiss;
      continue;
    }
    hit.t = t_[i];
    hit.node = nodes_[i];
    hit.primitive = primitives_[i];
    hit.state = hit.node != 0       ? HitState::kHit
                : std::isnan(hit.t) ? HitState::kInvalid
                                    : HitState::kMiss;
  }
  return hits;
}

}  // namespace sightline::bench
