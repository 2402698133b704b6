// Ways to find hits, held against each other by `robust`.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/published/any_builder.h"
#include "accel/result.h"
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
  virtual std::string builder() const = 0;      ///< By its name on the command line.
  virtual bool grows() const { return false; }  ///< Policy first-touch; else full.
  virtual bool exact() const { return false; }
  std::string policy() const { return grows() ? "first-touch" : "full"; }

  /// Makes itself ready for rays like these. Not timed.
  virtual void tune(std::span<const accel::geometry::Ray> rays) { (void)rays; }

  /// The nearest hits. Returns the seconds it took, building left out; with it where the method
  /// grows: it forgets its trees before.
  virtual Result<double> trace(std::span<const accel::geometry::Ray> rays,
                               std::span<accel::geometry::Hit> hits) = 0;
  /// How many triangles every ray crosses.
  virtual Status count(std::span<const accel::geometry::Ray> rays,
                       std::span<std::uint32_t> counts) = 0;
};

/// The product's, double transforms and all, over trees built before.
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

/// Embree, quality medium. Errors: as of EmbreePeer::make.
Result<std::unique_ptr<RobustMethod>> make_embree(const SceneSource& scene, bool robust,
                                                  int threads);

/// The scene as ray tracers in float have it: vertices in the world, rounded, no transforms. Nodes
/// keep their places.
SceneSource in_float_world(const SceneSource& scene);

}  // namespace sightline::bench
