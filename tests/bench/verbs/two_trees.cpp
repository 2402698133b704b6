// two-trees: the cost of visiting a static and a dynamic tree instead of one tree.
#include <fmt/core.h>

#include <array>
#include <memory>

#include "tests/bench/scenes/scene_geometry.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/frame_view.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::bench {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Mobility;

constexpr double kPartRadius = 0.005;  // Divided by the scene's diagonal
constexpr double kFarAway = 10;        // Likewise

// A way to hold the scene, and the way it is compared with.
struct Variant {
  const char* name;
  int base;  // An index in kVariants; its own index: none
  bool parts, far, group;
  Mobility mobility;
};

constexpr std::array<Variant, 5> kVariants{{
    {"static", 0, false, false, false, Mobility::kStatic},
    {"static, and an empty dynamic group", 0, false, false, true, Mobility::kRigid},
    {"static, and a dynamic part far away", 0, false, true, false, Mobility::kRigid},
    {"static, static parts in it", 3, true, false, false, Mobility::kStatic},
    {"static, dynamic parts in it", 3, true, false, false, Mobility::kRigid},
}};

struct Held {
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot;
  std::vector<double> trace_ms;
  scenegraph::TraceStats stats;
  std::string hash;
};

// Balls of one mesh, spread through the scene's box.
SceneSource with_parts(SceneSource scene, const Variant& variant, std::size_t count,
                       std::uint64_t seed) {
  const SceneGeometry geometry(scene);
  tests::TestMesh ball = tests::icosphere(3);
  const auto radius = static_cast<float>(kPartRadius * geometry.diagonal());
  for (Vec3f& v : ball.vertices) v = v * radius;
  const auto add = [&](const Vec3d& at, std::optional<std::size_t> mesh) {
    scene.add_node(std::nullopt, "part", translation(at.x, at.y, at.z), mesh);
    scene.nodes.back().mobility = variant.mobility;
  };
  if (variant.group) add({}, std::nullopt);
  if (!variant.far && !variant.parts) return scene;
  const Vec3d lo = geometry.lo(), hi = geometry.hi();
  const double far = kFarAway * geometry.diagonal();
  const std::size_t mesh = scene.add_mesh({ball.vertices, ball.faces});
  if (variant.far) add({hi.x + far, hi.y, hi.z}, mesh);
  tests::Random random(seed);
  for (std::size_t i = 0; variant.parts && i < count; ++i) {
    add({random.uniform(lo.x, hi.x), random.uniform(lo.y, hi.y), random.uniform(lo.z, hi.z)}, mesh);
  }
  return scene;
}

Row make_row(const CommonOptions& common, const TwoTreesOptions& options, std::size_t index,
             const std::vector<Held>& held) {
  const Held& mine = held[index];
  Row row;
  row["scene"] = common.scene;
  row["variant"] = kVariants[index].name;
  row["parts"] = kVariants[index].parts ? options.parts : 0;
  row["rays"] = options.rays.kind;
  row["count"] = options.rays.count;
  row["threads"] = common.threads;
  set_times(row, "trace_ms", mine.trace_ms);
  row["hits"] = mine.stats.hits;
  row["hit_hash"] = mine.hash;
  row["traversal_steps"] = mine.stats.traversal_steps;
  row["triangle_tests"] = mine.stats.triangle_tests;
  row["instances_entered"] = mine.stats.instances_entered;
  const auto base = static_cast<std::size_t>(kVariants[index].base);
  if (base == index) return row;
  std::vector<double> quotients;
  for (std::size_t i = 0; i < mine.trace_ms.size(); ++i)
    quotients.push_back(mine.trace_ms[i] / held[base].trace_ms[i]);
  row["over"] = kVariants[base].name;
  row["ratio"] = median(quotients);
  row["ratio_q1"] = quantile(quotients, 0.25);
  row["ratio_q3"] = quantile(quotients, 0.75);
  return row;
}

Status trace_once(const FrameView& view, Held& held, bool counted) {
  Seen seen;
  held.stats = {};
  const auto seconds = look(*held.snapshot, view, seen, held.stats);
  if (!seconds.ok()) return seconds.error();
  held.hash = seen.hash();
  if (counted) held.trace_ms.push_back(*seconds * 1e3);
  return {};
}

// Checks that answers are right and do not depend on the tree a part is in.
Status check(const CommonOptions& common, const SceneSource& scene, const FrameView& view,
             std::size_t index, const std::vector<Held>& held, std::size_t parts) {
  const auto base = static_cast<std::size_t>(kVariants[index].base);
  if (held[index].hash != held[base].hash) {
    return Error{
        Code::kDataLoss,
        fmt::format("answers of \"{}\" ({}) differ from those of \"{}\" ({})",
                    kVariants[index].name, held[index].hash, kVariants[base].name, held[base].hash),
        "HASHES_DIFFER"};
  }
  Seen seen;
  scenegraph::TraceStats unused;
  if (const auto s = look(*held[index].snapshot, view, seen, unused); !s.ok()) return s.error();
  const auto right = AnswerCheck::make(with_parts(scene, kVariants[index], parts, common.seed),
                                       view.rays, scenegraph::QueryKind::kClosest);
  if (!right.ok()) return right.error();
  return (*right)(seen.hits);
}

}  // namespace

Result<std::vector<Row>> run_two_trees(const CommonOptions& common,
                                       const TwoTreesOptions& options) {
  const auto policy = parse_policy(common.policy, scenegraph::Growth::kFirstTouch);
  if (!policy.ok()) return policy.error();
  const auto builder = configured_builder({}, common);
  if (!builder.ok()) return builder.error();
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  auto rays = make_rays(*scene, options.rays, common.seed);
  if (!rays.ok()) return rays.error();
  const FrameView view{std::move(rays).value(), false, {}};

  std::vector<Held> held;
  for (const Variant& variant : kVariants) {
    auto snapshot = assemble(with_parts(*scene, variant, options.parts, common.seed), *builder);
    if (!snapshot.ok()) return snapshot.error();
    held.push_back({std::move(snapshot).value(), {}, {}, {}});
    if (*policy == scenegraph::Growth::kFull) {
      if (const auto built = scenegraph::build_all(*held.back().snapshot); !built.ok())
        return built.error();
    }
    if (Status warm = trace_once(view, held.back(), false); !warm.ok()) return warm.error();
  }
  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    for (std::size_t k = 0; k < held.size(); ++k) {
      // Every other time in reverse order, so that no variant always follows the same one.
      const std::size_t index = repeat % 2 == 0 ? k : held.size() - 1 - k;
      if (Status s = trace_once(view, held[index], true); !s.ok()) return s.error();
    }
  }
  std::vector<Row> rows;
  for (std::size_t index = 0; index < held.size(); ++index) {
    if (Status s = check(common, *scene, view, index, held, options.parts); !s.ok())
      return s.error();
    rows.push_back(make_row(common, options, index, held));
  }
  return rows;
}

}  // namespace sightline::bench
