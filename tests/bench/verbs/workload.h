// Shared by the verbs: the requested scene, its rays, and the check of answers.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/result.h"
#include "scenegraph/trace.h"
#include "tests/bench/scenes/scene_source.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/stopwatch.h"
#include "tests/support/brute_force.h"

namespace sightline::bench {

/// The scene, loaded and rotated.
Result<SceneSource> make_scene(const CommonOptions& common);

/// `fallback` if --policy is not given.
Result<scenegraph::Growth> parse_policy(const std::string& policy, scenegraph::Growth fallback);
std::string_view policy_name(scenegraph::Growth growth);

/// "soup" or "runs".
Result<accel::mesh::References> parse_hierarchy(const std::string& name);

Result<std::vector<accel::geometry::Ray>> make_rays(const SceneSource& scene,
                                                    const RayOptions& rays, std::uint64_t seed);

/// Checks a sample of answers with brute force.
class AnswerCheck {
 public:
  /// Keeps a copy of the scene's arrays.
  static Result<AnswerCheck> make(const SceneSource& scene,
                                  std::span<const accel::geometry::Ray> rays,
                                  scenegraph::QueryKind kind);
  /// Error: kDataLoss, naming the differences.
  Status operator()(std::span<const accel::geometry::Hit> hits) const;

 private:
  explicit AnswerCheck(tests::BruteForce oracle) : oracle_(std::move(oracle)) {}
  tests::BruteForce oracle_;
  std::vector<std::size_t> sample_;
  std::vector<accel::geometry::Ray> rays_;
  scenegraph::QueryKind kind_{};
};

}  // namespace sightline::bench
