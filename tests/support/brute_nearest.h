// The oracle for closest points: every face of every instance, each distance rounded once. Bounds
// in doubles reject faces that are certainly farther, 113 bits decide the rest, and rationals what
// those leave open. Shares no code with the rule and the walks that it checks.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "scenegraph/revision/snapshot.h"
#include "tests/support/brute_force.h"

namespace sightline::tests {

/// In the order of closest points.
struct NearFace {
  double distance = 0;
  std::uint64_t node = 0;
  std::uint32_t primitive = 0;

  auto operator<=>(const NearFace&) const = default;
};

/// The nodes that a query sees: those that share a bit with the mask and are accepted.
struct NodeFilter {
  std::uint32_t mask = accel::geometry::kAllMasks;
  std::function<bool(std::uint64_t node)> accepts{};  ///< Empty: all.
};

/// Faces with a missing or non-finite vertex do not exist; all others do, without area too.
/// Coordinates of points are finite, world coordinates below 2^1000, and `max_distance` is a
/// number: a face at exactly that distance counts, and none does below 0. Threads: any, whose
/// denormal numbers are not flushed to zero.
class BruteNearest {
 public:
  static constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

  explicit BruteNearest(std::vector<PlacedMesh> meshes);
  /// Over placed_meshes(*snapshot). Shares ownership of the snapshot.
  explicit BruteNearest(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot);

  /// The first `most` of the faces within `max_distance`, in order.
  std::vector<NearFace> all(const accel::geometry::Vec3d& p, double max_distance,
                            std::size_t most = kNoLimit, const NodeFilter& filter = {}) const;
  std::optional<NearFace> closest(const accel::geometry::Vec3d& p, double max_distance,
                                  const NodeFilter& filter = {}) const;
  /// All faces at the least distance that is within `max_distance`, in order.
  std::vector<NearFace> all_closest(const accel::geometry::Vec3d& p, double max_distance,
                                    const NodeFilter& filter = {}) const;
  /// The number of faces within `max_distance`.
  std::uint64_t count(const accel::geometry::Vec3d& p, double max_distance,
                      const NodeFilter& filter = {}) const;
  /// `closest` of each point. Parallel in the calling thread's oneTBB arena.
  std::vector<std::optional<NearFace>> closest(std::span<const accel::geometry::Vec3d> points,
                                               double max_distance,
                                               const NodeFilter& filter = {}) const;

 private:
  static constexpr std::size_t kLanes = 32;

  struct Box {
    accel::geometry::Vec3d lo, hi;
  };

  /// Neighboring faces in double world coordinates.
  struct Chunk {
    Box box;
    std::size_t count = 0;
    std::array<std::uint32_t, kLanes> face{};
    std::array<std::array<accel::geometry::Vec3d, 3>, kLanes> corner{};
  };

  struct Instance {
    PlacedMesh placed;
    double magnitude = 0;  // Bounds the terms of the sums that are world coordinates
    std::vector<Chunk> chunks;
  };

  struct NearChunk;

  static Instance make_instance(const PlacedMesh& placed);
  static void make_chunks(Instance& instance, std::span<std::uint32_t> faces);
  static double distance_below(const Box& box, const accel::geometry::Vec3d& p, double pad);
  static double exact_distance(const Instance& instance, std::uint32_t face,
                               const accel::geometry::Vec3d& p);
  std::vector<NearFace> first_and_ties(const accel::geometry::Vec3d& p, double max_distance,
                                       std::size_t most, const NodeFilter& filter) const;
  template <class Found>
  static void visit_chunk(const NearChunk& near, const accel::geometry::Vec3d& p, Found& found);
  template <class Found>
  void visit(const accel::geometry::Vec3d& p, const double& limit, const NodeFilter& filter,
             Found&& found) const;

  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  std::vector<Instance> instances_;
};

}  // namespace sightline::tests
