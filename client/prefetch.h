// Building trees before rays come: what is asked for, and how far it has come.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <vector>

#include "client/cast_options.h"

namespace sightline::client {

struct PrefetchOptions {
  /// Only these nodes and those under them; none: all. With rays at most one. Errors: kNotFound, as
  /// for `exclude`.
  std::vector<std::uint64_t> roots{};
  /// Not these nodes and those under them.
  std::vector<std::uint64_t> exclude{};
  /// Of rays: what a cast of this kind would build. kCount and kAll: all that is on their way.
  QueryKind kind = QueryKind::kClosest;
  /// Cancels the building, which then ends with kCancelled. What is built stays.
  std::stop_token stop{};
};

struct PrefetchReport {
  std::uint64_t revision = 0;      ///< Of the scene whose trees are built.
  std::uint64_t meshes_done = 0;   ///< Whose trees are complete; without rays, as the next three.
  std::uint64_t meshes_total = 0;  ///< Distinct.
  std::uint64_t triangles_done = 0;  ///< Of the meshes that are done.
  std::uint64_t triangles_total = 0;
  std::uint64_t rays_done = 0;
  std::uint64_t cells_expanded = 0;  ///< By this call.
  std::uint64_t bytes_trees = 0;     ///< Of what is asked for; without rays.
  std::uint64_t build_us = 0;        ///< Growing trees, summed over the server's threads.
  std::uint64_t elapsed_us = 0;      ///< At the server.
};

/// Told a few times a second how far the building has come, and at its end, on the calling thread.
/// Numbers only grow.
using PrefetchProgress = std::function<void(const PrefetchReport&)>;

}  // namespace sightline::client
