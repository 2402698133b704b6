// Options and progress of a prefetch, which builds trees before rays come.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <vector>

#include "client/cast_options.h"

namespace sightline::client {

struct PrefetchOptions {
  /// Builds only for these nodes and their descendants. Empty: all nodes. With rays or points, at
  /// most one. Errors: kNotFound, as for `exclude`.
  std::vector<std::uint64_t> roots{};
  /// Leaves out these nodes and their descendants.
  std::vector<std::uint64_t> exclude{};
  /// Builds only for nodes that have one of these labels and their descendants. Empty: all nodes.
  std::vector<LabelMatch> only_labels{};
  /// Leaves out nodes that have one of these labels and their descendants.
  std::vector<LabelMatch> exclude_labels{};
  /// With rays or points: builds what a query of this kind would build. kCount and kAll build all
  /// cells on the rays' way, or in the balls of the points.
  QueryKind kind = QueryKind::kClosest;
  /// Cancels the building, which then fails with kCancelled. Built cells stay.
  std::stop_token stop{};
};

struct PrefetchReport {
  std::uint64_t revision = 0;  ///< the revision of the scene whose trees are built
  /// Meshes whose trees are complete; only without rays or points, like the next three
  std::uint64_t meshes_done = 0;
  std::uint64_t meshes_total = 0;  ///< distinct meshes
  /// The triangles of the complete meshes, and those in finished leaves of others.
  std::uint64_t triangles_done = 0;
  std::uint64_t triangles_total = 0;
  std::uint64_t rays_done = 0;
  std::uint64_t cells_expanded = 0;  ///< by this call
  std::uint64_t bytes_trees = 0;     ///< bytes of the requested trees; only without rays
  std::uint64_t build_us = 0;        ///< time to build trees, summed over the server's threads
  std::uint64_t elapsed_us = 0;      ///< wall time at the server
};

/// Called a few times per second, and at the end, on the calling thread. The numbers never
/// decrease.
using PrefetchProgress = std::function<void(const PrefetchReport&)>;

}  // namespace sightline::client
