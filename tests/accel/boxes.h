// Lists of boxes as input for builders.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/reference.h"
#include "tests/support/random.h"

namespace sightline::tests {

inline accel::kdtree::Reference box_ref(const accel::geometry::Vec3f& lo,
                                        const accel::geometry::Vec3f& hi, std::uint32_t id = 0,
                                        std::uint32_t weight = 1) {
  const accel::geometry::Aabb box = accel::geometry::widen_flat({lo, hi});
  return {box.lo, id, box.hi, weight};
}

/// Corners uniform in the unit cube, extents uniform up to `size`.
inline std::vector<accel::kdtree::Reference> random_boxes(std::size_t n, double size,
                                                          std::uint64_t seed) {
  Random random(seed);
  std::vector<accel::kdtree::Reference> refs;
  for (std::size_t i = 0; i < n; ++i) {
    const auto x = [&] { return static_cast<float>(random.uniform()); };
    const accel::geometry::Vec3f lo{x(), x(), x()};
    const auto e = [&] { return static_cast<float>(random.uniform() * size); };
    refs.push_back(
        box_ref(lo, lo + accel::geometry::Vec3f{e(), e(), e()}, static_cast<std::uint32_t>(i)));
  }
  return refs;
}

/// Bounds on a coarse lattice, many of them flat, weights of 1 to `heaviest`.
inline std::vector<accel::kdtree::Reference> lattice_boxes(std::size_t n, std::uint32_t heaviest,
                                                           std::uint64_t seed) {
  Random random(seed);
  std::vector<accel::kdtree::Reference> refs;
  for (std::size_t i = 0; i < n; ++i) {
    const auto x = [&] { return static_cast<float>(random.below(6)); };
    accel::geometry::Aabb box;
    box.grow(accel::geometry::Vec3f{x(), x(), x()});
    box.grow(accel::geometry::Vec3f{x(), x(), x()});
    const auto weight = static_cast<std::uint32_t>(1 + random.below(heaviest));
    refs.push_back(box_ref(box.lo, box.hi, static_cast<std::uint32_t>(i), weight));
  }
  return refs;
}

}  // namespace sightline::tests
