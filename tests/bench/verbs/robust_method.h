// Ways to find hits, compared with each other by `robust`.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/published/any_builder.h"
#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// Threads: one caller, in an oneTBB arena.
class RobustMethod {
 public:
  virtual ~RobustMethod() = default;
  RobustMethod() = default;
  RobustMethod(const RobustMethod&) = delete;
  RobustMethod& operator=(const RobustMethod&) = delete;

  virtual std::string name() const = 0;         ///< exact, plain-float, embree or embree-robust.
  virtual std::string builder() const = 0;      ///< Its name on the command line.
  virtual bool grows() const { return false; }  ///< Policy first-touch; otherwise full.
  virtual bool exact() const { return false; }
  std::string policy() const { return grows() ? "first-touch" : "full"; }

  /// Prepares for rays like these. Not timed.
  virtual void tune(std::span<const accel::geometry::Ray> rays) { (void)rays; }

  /// Finds the nearest hits. Returns the seconds without building; a method that grows drops its
  /// trees first, and its building is included.
  virtual Result<double> trace(std::span<const accel::geometry::Ray> rays,
                               std::span<accel::geometry::Hit> hits) = 0;
  /// The number of triangles that each ray crosses.
  virtual Status count(std::span<const accel::geometry::Ray> rays,
                       std::span<std::uint32_t> counts) = 0;
};

/// The product's method, with double transforms, over trees built before.
Result<std::unique_ptr<RobustMethod>> make_exact_full(const SceneSource& scene,
                                                      const std::string& builder_name,
                                                      const accel::published::AnyBuilder& builder);
/// The same while the trees grow.
std::unique_ptr<RobustMethod> make_exact_lazy(const SceneSource& scene,
                                              const std::string& builder_name,
                                              const accel::published::AnyBuilder& builder);

/// Float vertices in the world, rays rounded to float, and PlainFloat in the product's walk.
Result<std::unique_ptr<RobustMethod>> make_plain_float(const SceneSource& scene,
                                                       const std::string& builder_name,
                                                       const accel::published::AnyBuilder& builder);

/// Embree, quality medium. Errors: those of EmbreePeer::make.
Result<std::unique_ptr<RobustMethod>> make_embree(const SceneSource& scene, bool robust,
                                                  int threads);

/// The scene as float ray tracers have it: vertices in world space, rounded, no transforms. Nodes
/// keep their indices.
SceneSource in_float_world(const SceneSource& scene);

}  // namespace sightline::bench
