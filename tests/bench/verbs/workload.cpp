// What the verbs share.
#include "tests/bench/verbs/workload.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "tests/bench/scenes/load_scene.h"
#include "tests/support/compare_hits.h"

namespace sightline::bench {
namespace {

constexpr std::size_t kSampleRays = 200;

Error invalid(std::string message) {
  return {Code::kInvalidArgument, std::move(message), "COMMAND_LINE"};
}

Result<scenegraph::model::Affine> parse_rotation(std::string_view text) {
  std::array<double, 3> degrees{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [next, error] = std::from_chars(at, end, degrees[i]);
    const bool separated = i == 2 ? next == end : next != end && *next == ',';
    if (error != std::errc() || !separated || !std::isfinite(degrees[i])) {
      return invalid(fmt::format("--rotate \"{}\" is not x,y,z in degrees", text));
    }
    at = next + 1;
  }
  return rotation(degrees[0], degrees[1], degrees[2]);
}

}  // namespace

Result<SceneSource> make_scene(const CommonOptions& common) {
  if (common.scene.empty()) return invalid("--scene is required");
  auto scene = load_scene(common.scene);
  if (!scene.ok()) return scene;
  if (common.merge) *scene = merged(*scene);
  if (common.rotate.empty()) return scene;
  const auto turn = parse_rotation(common.rotate);
  if (!turn.ok()) return turn.error();
  rotate(*scene, *turn);
  return scene;
}

Result<scenegraph::Growth> parse_policy(const std::string& policy, scenegraph::Growth fallback) {
  if (policy.empty()) return fallback;
  if (policy == "first-touch") return scenegraph::Growth::kFirstTouch;
  if (policy == "demand") return scenegraph::Growth::kDemand;
  if (policy == "full") return scenegraph::Growth::kFull;
  return invalid(fmt::format("no policy \"{}\"; there are: first-touch demand full", policy));
}

std::string_view policy_name(scenegraph::Growth growth) {
  if (growth == scenegraph::Growth::kDemand) return "demand";
  return growth == scenegraph::Growth::kFull ? "full" : "first-touch";
}

Result<accel::mesh::References> parse_hierarchy(const std::string& name) {
  if (name == "soup") return accel::mesh::References::kSoup;
  if (name == "runs") return accel::mesh::References::kRuns;
  return invalid(fmt::format("no hierarchy \"{}\"; there are: soup runs", name));
}

Result<std::vector<accel::geometry::Ray>> make_rays(const SceneSource& scene,
                                                    const RayOptions& rays, std::uint64_t seed) {
  const auto kind = parse_ray_kind(rays.kind);
  if (!kind.ok()) return kind.error();
  return make_rays(scene, *kind, rays.count, seed);
}

Result<AnswerCheck> AnswerCheck::make(const SceneSource& scene,
                                      std::span<const accel::geometry::Ray> rays,
                                      scenegraph::QueryKind kind) {
  auto snapshot = assemble(scene, {});
  if (!snapshot.ok()) return snapshot.error();
  AnswerCheck check{tests::BruteForce(*std::move(snapshot))};
  const std::size_t count = std::min(kSampleRays, rays.size());
  for (std::size_t i = 0; i < count; ++i) {
    check.sample_.push_back(i * rays.size() / count);
    check.rays_.push_back(rays[check.sample_.back()]);
  }
  check.kind_ = kind;
  return check;
}

Status AnswerCheck::operator()(std::span<const accel::geometry::Hit> hits) const {
  std::vector<accel::geometry::Hit> sampled;
  for (const std::size_t i : sample_) sampled.push_back(hits[i]);
  const tests::Comparison result =
      compare(rays_, sampled, oracle_, {.any = kind_ == scenegraph::QueryKind::kAny});
  if (result.mismatches == 0) return {};
  return Error{Code::kDataLoss, "answers differ from brute force: " + result.report(), "MISMATCH"};
}

}  // namespace sightline::bench
