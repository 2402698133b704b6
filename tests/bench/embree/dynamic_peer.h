// Embree with a moving part that is rebuilt or refitted every frame, and a static part that is
// built once.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "tests/bench/scenes/motion.h"
#include "tests/bench/scenes/staged_scene.h"

namespace sightline::bench {

enum class EmbreeUpdate : std::uint8_t {
  kRebuild,  ///< RTC_BUILD_QUALITY_LOW, every frame.
  kRefit,    ///< RTC_BUILD_QUALITY_REFIT: the tree of the first frame with new boxes.
};

/// All geometry is transformed to world space; instances of the static part are copied. Moving
/// vertices are written into buffers shared with Embree.
/// Threads: one caller, in an oneTBB arena of `threads` threads.
class EmbreeDynamicPeer {
 public:
  /// `scene` and `motion` must outlive it. Errors: as EmbreePeer::make.
  static Result<std::unique_ptr<EmbreeDynamicPeer>> make(const StagedScene& scene,
                                                         const Motion& motion, EmbreeUpdate update,
                                                         int threads);
  virtual ~EmbreeDynamicPeer() = default;

  /// Tries all layouts (all geometries in one scene of two levels; one scene for each part under
  /// instances; for rigid motion also one instance for each node), each with every entry point, on
  /// these rays over a few frames, and keeps the fastest. Must be called first.
  virtual Status choose(std::span<const accel::geometry::Ray> rays) = 0;
  virtual std::string layout() const = 0;
  virtual std::string entry(bool any) const = 0;
  /// Chooses the fastest entry point for these occlusion rays.
  virtual void choose_any(std::span<const accel::geometry::Ray> rays) = 0;

  struct Advanced {
    double update_seconds = 0;  ///< Writing vertices or transforms.
    double build_seconds = 0;   ///< Committing geometries and scenes.
  };
  /// Errors: kInternal: Embree's error.
  virtual Result<Advanced> advance(std::size_t frame) = 0;

  /// As EmbreePeer::trace, all rays at once.
  virtual double trace(std::span<const accel::geometry::Ray> rays, bool any,
                       std::span<accel::geometry::Hit> hits) = 0;
};

}  // namespace sightline::bench
