// The builders of kd-trees, and what growing asks of whichever it is.
#pragma once

#include <cstddef>
#include <optional>
#include <variant>

#include "accel/published/kd/exact_builder.h"
#include "accel/published/kd/median_builders.h"
#include "accel/published/kd/min_max_builder.h"
#include "accel/split/scan_builder.h"

namespace sightline::accel::split {

/// Made without a name it is a scan builder with its default parameters.
using KdBuilder = std::variant<ScanBuilder, published::kd::SpatialMedianBuilder,
                               published::kd::ObjectMedianBuilder, published::kd::ExactBuilder,
                               published::kd::MinMaxBuilder>;

/// Where the builder cuts a cell; nothing for a leaf.
std::optional<kdtree::Cut> choose_cut(const KdBuilder& builder, const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters);

/// Whether straddlers of a cut are clipped that leaves so many of a cell's references on both
/// sides.
template <class Builder>
bool clips_straddlers(const Builder& builder, const kdtree::CellPath& path, std::size_t straddlers,
                      std::size_t references) {
  if constexpr (requires { builder.clips(path, straddlers, references); }) {
    return builder.clips(path, straddlers, references);
  } else {
    return builder.clips();
  }
}
bool clips(const KdBuilder& builder, const kdtree::CellPath& path, std::size_t straddlers,
           std::size_t references);

/// Whether the builder can look at a list through passes alone (CellRefs::run); the others need it
/// whole and at hand.
bool runs_passes(const KdBuilder& builder);

/// Whether the builder wants the lists that come of sifting one of so many boxes counted meanwhile
/// (sift_and_scan), to be handed to it as CellRefs::first.
bool scans_children(const KdBuilder& builder, std::size_t references);

/// For builders that scan children: where the first pass over the list of that cell counts.
FirstPlanes first_planes(const KdBuilder& builder, const geometry::Aabb& child);

}  // namespace sightline::accel::split
