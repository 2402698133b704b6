// Points asked in one of many ways, and their answers compared with the oracle's.
#include "tests/support/point_ways.h"

#include <fmt/core.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "tests/support/on_target.h"

namespace sightline::tests {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using scenegraph::Growth;
using scenegraph::QueryKind;
using scenegraph::RayTally;

constexpr std::array<std::string_view, kTreeStates> kStateNames{
    "none", "first-touch", "demand", "full", "cooled", "built-only"};
constexpr std::array<std::string_view, 4> kKindNames{"closest", "any", "count", "all"};
constexpr std::array<std::size_t, 4> kBatches{1, 7, 64, 8192};
constexpr std::size_t kMostExamples = 3;
// Faces of all points together that are tested without a tree.
constexpr std::size_t kMostTests = 4'000'000;

Growth growth_of(TreeState state) {
  switch (state) {
    case TreeState::kNone:
      return Growth::kNone;
    case TreeState::kDemand:
      return Growth::kDemand;
    case TreeState::kBuiltOnly:
      return Growth::kBuiltOnly;
    default:
      return Growth::kFirstTouch;
  }
}

bool is_face(const Hit& hit, const NearFace& face) {
  return hit.t == face.distance && hit.node == face.node && hit.primitive == face.primitive;
}

// One batch with the answers of one kind.
class Batch {
 public:
  Batch(const scenegraph::revision::Snapshot& snapshot, const CheckedPoints& points,
        std::size_t first, std::size_t count, const PointWay& way)
      : points_(points), way_(way), first_(first) {
    for (std::size_t i = first; i < first + count; ++i)
      rays_.push_back({.origin = points.at[i], .direction = {1, 0, 0}, .tmax = limit(i)});
    options_.points = true;
    options_.kind = way.kind;
    options_.growth = growth_of(way.state);
    hits_.resize(count);
    tallies_.resize(count);
    done_ = ask(snapshot);
  }

  PointComparison compare() {
    PointComparison result;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      ++result.checked;
      if (done_ && is_right(i)) continue;
      ++result.mismatches;
      if (result.examples.size() < kMostExamples) result.examples.push_back(describe(i));
    }
    return result;
  }

 private:
  double limit(std::size_t point) const {
    if (way_.kind == QueryKind::kClosest || points_.nearest[point].empty())
      return accel::geometry::kInfinity;
    const double distance = points_.nearest[point].front().distance;
    return point % 2 == 0 ? distance : std::nextafter(distance, -1.0);
  }

  bool ask(const scenegraph::revision::Snapshot& snapshot) {
    if (way_.kind == QueryKind::kCount)
      return scenegraph::count_hits(snapshot, rays_, tallies_, options_).ok();
    if (way_.kind == QueryKind::kAll)
      return scenegraph::list_hits(snapshot, rays_, tallies_, hits_, options_).ok();
    return scenegraph::trace(snapshot, rays_, hits_, options_).ok();
  }

  // The faces that the answer has.
  std::span<const NearFace> expected(std::size_t i) const {
    const std::vector<NearFace>& nearest = points_.nearest[first_ + i];
    const bool within = way_.kind == QueryKind::kClosest || (first_ + i) % 2 == 0;
    return within ? std::span<const NearFace>(nearest) : std::span<const NearFace>();
  }

  bool is_right(std::size_t i) {
    const std::span<const NearFace> faces = expected(i);
    if (way_.kind == QueryKind::kCount) return tallies_[i].count == faces.size();
    if (way_.kind == QueryKind::kAll) return is_list_right(tallies_[i], faces);
    const Hit& hit = hits_[i];
    const bool is_hit = hit.state == HitState::kHit;
    if (way_.state == TreeState::kBuiltOnly && (hit.work & accel::geometry::kWorkDeferred) != 0) {
      if (!is_hit || way_.kind == QueryKind::kAny) return !is_hit || !faces.empty();
      return !faces.empty() && hit.t >= faces.front().distance;
    }
    if (is_hit == faces.empty()) return false;
    return !is_hit || way_.kind == QueryKind::kAny || is_face(hit, faces.front());
  }

  // Lists follow each other.
  bool is_list_right(const RayTally& tally, std::span<const NearFace> faces) {
    const std::span<const Hit> listed = std::span<const Hit>(hits_).subspan(listed_, tally.count);
    listed_ += tally.count;
    if (tally.count != std::min<std::size_t>(faces.size(), options_.max_hits)) return false;
    return std::equal(listed.begin(), listed.end(), faces.begin(), faces.begin() + tally.count,
                      is_face);
  }

  std::string describe(std::size_t i) const {
    const accel::geometry::Vec3d& p = rays_[i].origin;
    std::string text = fmt::format("({}, {}, {}) {}:", p.x, p.y, p.z, way_.text());
    if (!done_) return text + " failed";
    if (way_.kind == QueryKind::kClosest)
      text += fmt::format(" {} from {}, {}", hits_[i].t, hits_[i].node, hits_[i].primitive);
    const std::span<const NearFace> faces = expected(i);
    text += fmt::format(" instead of {} faces", faces.size());
    if (!faces.empty())
      text +=
          fmt::format(" at {} from {}, {}", faces[0].distance, faces[0].node, faces[0].primitive);
    return text;
  }

  const CheckedPoints& points_;
  const PointWay& way_;
  const std::size_t first_;
  std::vector<Ray> rays_;
  scenegraph::TraceOptions options_;
  std::vector<Hit> hits_;
  std::vector<RayTally> tallies_;
  std::size_t listed_ = 0;
  bool done_ = false;
};

}  // namespace

std::string PointWay::text() const {
  return fmt::format(
      "{}, {}, {}, {} threads, batches of {}", kKindNames[static_cast<std::size_t>(kind)],
      kStateNames[static_cast<std::size_t>(state)], hwy::TargetName(target), threads, batch);
}

PointWay point_way(std::size_t n) {
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  PointWay way;
  way.state = static_cast<TreeState>(n % kTreeStates);
  n /= kTreeStates;
  // Shifted by the state, so that the states of one round differ in all else.
  const std::size_t shifted = n + static_cast<std::size_t>(way.state);
  way.target = targets[shifted % targets.size()];
  way.batch = kBatches[shifted / targets.size() % kBatches.size()];
  way.threads = 1 + static_cast<int>(shifted / (targets.size() * kBatches.size()) % 2);
  return way;
}

PointComparison& PointComparison::operator+=(const PointComparison& other) {
  checked += other.checked;
  mismatches += other.mismatches;
  for (const std::string& example : other.examples) {
    if (examples.size() < kMostExamples) examples.push_back(example);
  }
  return *this;
}

PointComparison compare_points(const std::vector<ScenePart>& parts, const CheckedPoints& points,
                               const PointWay& way) {
  const OnTarget target(way.target);
  tbb::task_arena arena(way.threads);
  return arena.execute([&] {
    const FreshScene scene(parts);
    const scenegraph::revision::Snapshot& snapshot = *scene.snapshot();
    if (way.state == TreeState::kFull) (void)scenegraph::build_all(snapshot);
    if (way.state > TreeState::kFull) {
      scene.build_meshes();
      scene.cool();
    }
    std::size_t count = points.at.size();
    if (way.state == TreeState::kNone)
      count = std::min(count, std::max<std::size_t>(kMostTests / scene.faces(), 16));
    PointComparison result;
    for (std::size_t first = 0; first < count; first += way.batch)
      result += Batch(snapshot, points, first, std::min(way.batch, count - first), way).compare();
    return result;
  });
}

}  // namespace sightline::tests
