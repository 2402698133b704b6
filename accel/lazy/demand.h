// When rays pay for building: what the rule of demand knows of the rays that wait at a cell, and
// decides. docs/decisions/growth.md has the argument.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/geometry/local_ray.h"

namespace sightline::accel::lazy {

/// A cell's box is divided into this many parts along each axis, to see where rays pass.
inline constexpr std::size_t kParts = 8;

/// The parts that a ray passes, in its order; some repeat.
using CellPassage = std::array<std::uint16_t, 2 * kParts>;
CellPassage passage(const geometry::LocalRay& ray, const geometry::Aabb& box);

/// The part that holds a point, or the next one.
std::uint16_t part_of(const geometry::Vec3d& point, const geometry::Aabb& box);

/// Some of a cell's references by part, as shares of its weight.
using PartShares = std::array<double, kParts * kParts * kParts>;

/// The share of a cell's leaf blocks that rays reach: each stands for `rays_each`, and passes no
/// more than two parts with references. `blocks`: of the cell.
double share_reached(std::span<const CellPassage> passages, double rays_each,
                     const PartShares& shares, double blocks);

}  // namespace sightline::accel::lazy
