// curve: the cost of splitting the whole scene along one axis, from samples and exactly. Paper 000,
// Figures 2 to 6.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "accel/published/any_builder.h"
#include "accel/split/scan_split.h"
#include "tests/bench/scenes/scene_geometry.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/cost_curve.h"

namespace sightline::bench {
namespace {

using accel::geometry::Aabb;
using accel::kdtree::Reference;

// The scene's triangles in world space, as the builder sees them.
std::vector<Reference> world_boxes(const SceneGeometry& geometry) {
  std::vector<Reference> refs;
  refs.reserve(geometry.triangles());
  for (std::uint64_t n = 0; n < geometry.triangles(); ++n) {
    Aabb box;
    for (const accel::geometry::Vec3d& corner : geometry.triangle(n))
      box.grow(accel::geometry::Vec3f(corner));
    box = accel::geometry::widen_flat(box);
    refs.push_back({box.lo, static_cast<std::uint32_t>(n), box.hi, 1});
  }
  return refs;
}

struct Curve {
  std::string scene;
  char axis;
  accel::split::SahConstants cost;
  accel::split::SplitAreas areas;

  Row row(const char* what, double x, double left, double right) const {
    Row row;
    row["scene"] = scene;
    row["axis"] = std::string(1, axis);
    row["what"] = what;
    row["position"] = x;
    row["left"] = left;
    row["right"] = right;
    row["cost"] = split_cost(cost, areas, x, left, right);
    return row;
  }
};

// Even points, and the two sides of the steepest step in every interval that holds over 1 % of the
// rise: this draws jumps as jumps without a row for every box. All points are floats, as planes
// are.
std::vector<float> stations(const tests::TrueCounts& truth, float lo, float hi, int points) {
  std::vector<float> at;
  for (int i = 0; i <= points; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(points);
    at.push_back(i == points ? hi : lo + (hi - lo) * share);
  }
  const auto rise = [&](float p, float q) {
    const auto x = static_cast<double>(p), y = static_cast<double>(q);
    return truth.left(y) - truth.right(y) - truth.left(x) + truth.right(x);
  };
  for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i) {
    float below = at[i], above = at[i + 1];
    if (rise(below, above) < rise(lo, hi) / 100) continue;
    while (std::nextafter(below, above) < above) {
      const float middle = std::midpoint(below, above);
      (rise(below, middle) > rise(middle, above) ? above : below) = middle;
    }
    at.push_back(below);
    at.push_back(above);
  }
  std::sort(at.begin(), at.end());
  return at;
}

}  // namespace

Result<std::vector<Row>> run_curve(const CommonOptions& common, const CurveOptions& options) {
  const auto builder = configured_builder("scan-one-axis", common);
  if (!builder.ok()) return builder.error();
  const auto& scan =
      std::get<accel::published::kd::HuntScan>(std::get<accel::published::KdBuilder>(*builder));
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const SceneGeometry geometry(*scene);
  if (geometry.empty()) {
    return Error{Code::kFailedPrecondition, "the scene has no triangles", "NO_TRIANGLES"};
  }
  const std::vector<Reference> refs = world_boxes(geometry);
  Aabb cell;
  for (const Reference& ref : refs) cell.grow(ref.bounds());

  const int axis = options.axis - 'x';
  const auto a = static_cast<std::size_t>(axis);
  const Curve curve{common.scene, options.axis, scan.cost, accel::split::SplitAreas(cell, axis)};
  accel::kdtree::BuildCounters counters;
  const auto uniform = accel::published::kd::sample_axes(refs, cell, {axis, axis + 1},
                                                         scan.uniform_samples, 0, counters)[a];
  const auto both = accel::published::kd::sample_axes(
      refs, cell, {axis, axis + 1}, scan.uniform_samples, scan.adaptive_samples, counters)[a];
  const auto segments = tests::segments(both);
  const tests::TrueCounts truth(refs, a);

  std::vector<Row> rows;
  for (std::size_t i = 0; i < uniform.size; ++i) {
    const accel::published::kd::Sample& s = uniform.at[i];
    rows.push_back(curve.row("uniform", s.position, s.left, s.right));
  }
  for (std::size_t i = 0; i < both.size; ++i) {
    const accel::published::kd::Sample& s = both.at[i];
    const auto first = uniform.at.begin();
    const bool old = std::any_of(
        first, first + static_cast<std::ptrdiff_t>(uniform.size),
        [&](const accel::published::kd::Sample& u) { return u.position == s.position; });
    if (!old) rows.push_back(curve.row("adaptive", s.position, s.left, s.right));
  }
  for (const float at : stations(truth, cell.lo[a], cell.hi[a], options.points)) {
    const auto x = static_cast<double>(at);
    const tests::SampleSegment& segment = tests::segment_at(segments, x);
    rows.push_back(curve.row("suggested", x, segment.left(x), segment.right(x)));
    rows.push_back(curve.row("true", x, truth.left(x), truth.right(x)));
  }
  return rows;
}

}  // namespace sightline::bench
