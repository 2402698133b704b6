// How far a full build has come.
#pragma once

#include <atomic>
#include <cstdint>

namespace sightline::scenegraph::query {

/// Written by build_all, for whoever wants to show it. Numbers only grow, and the totals are set
/// before anything is done. Threads: any may read at any time.
struct BuildProgress {
  std::atomic<std::uint64_t> meshes_total{0};  ///< Distinct meshes of the revision.
  std::atomic<std::uint64_t> meshes_done{0};   ///< Whose tree is built to its end.
  std::atomic<std::uint64_t> triangles_total{0};
  std::atomic<std::uint64_t> triangles_done{0};  ///< Of the meshes that are done.

  /// From 0 to 1, by triangles; 0 while the totals are not known.
  double share() const {
    const std::uint64_t total = triangles_total.load(std::memory_order_relaxed);
    const std::uint64_t done = triangles_done.load(std::memory_order_relaxed);
    return total == 0 ? 0 : static_cast<double>(done) / static_cast<double>(total);
  }
};

}  // namespace sightline::scenegraph::query
