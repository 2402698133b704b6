// Embree with a part that moves: rebuilt or refitted every frame, beside a part that was built
// once.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "tests/bench/scenes/motion.h"
#include "tests/bench/scenes/staged_scene.h"

namespace sightline::bench {

enum class EmbreeUpdate : std::uint8_t {
  kRebuild,  ///< RTC_BUILD_QUALITY_LOW, every frame.
  kRefit,    ///< RTC_BUILD_QUALITY_REFIT: the tree of the first frame, its boxes made anew.
};

/// Everything is laid in the world; where the static part has instances, as copies. Vertices that
/// move are written into buffers which Embree shares.
/// Threads: one caller, in an oneTBB arena of `threads` threads.
class EmbreeMover {
 public:
  /// `scene` and `motion` must outlive it. Errors: as EmbreePeer::make.
  static Result<std::unique_ptr<EmbreeMover>> make(const StagedScene& scene, const Motion& motion,
                                                   EmbreeUpdate update, int threads);
  virtual ~EmbreeMover() = default;

  /// Tries the ways to lay the scene out (all geometries in one scene of two levels; a scene for
  /// each part under instances; of rigid motion also an instance a node), each with every entry
  /// point on these rays, over a few frames, and keeps the fastest. To be called first.
  virtual Status choose(std::span<const accel::geometry::Ray> rays) = 0;
  virtual std::string layout() const = 0;
  virtual std::string entry(bool any) const = 0;
  /// The fastest entry point for these occlusion rays.
  virtual void choose_any(std::span<const accel::geometry::Ray> rays) = 0;

  struct Advanced {
    double update_seconds = 0;  ///< Writing vertices or transforms.
    double build_seconds = 0;   ///< Committing geometries and scenes.
  };
  /// Errors: kInternal: what Embree says.
  virtual Result<Advanced> advance(std::size_t frame) = 0;

  /// As EmbreePeer::trace, all rays at once.
  virtual double trace(std::span<const accel::geometry::Ray> rays, bool any,
                       std::span<accel::geometry::Hit> hits) = 0;
};

}  // namespace sightline::bench
