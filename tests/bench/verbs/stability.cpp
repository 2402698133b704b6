// stability: all builders over the meshes on which methods fail, checked with the oracle and
// against bounds.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "accel/published/any_builder.h"
#include "tests/bench/scenes/generators.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/stability_family.h"
#include "tests/bench/verbs/tree_figures.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/hard_meshes.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using scenegraph::Growth;
using scenegraph::revision::Snapshot;
using tests::HardMesh;

// This builder counts its list again for every candidate: its time is quadratic.
constexpr std::string_view kQuadratic = "sah-naive";
constexpr std::uint64_t kMostForQuadratic = 1000;
// The work a ray of this builder's trees is the reference for the others.
constexpr std::string_view kMeasure = "sah-sweep";

struct NamedBuilder {
  std::string name;
  accel::published::AnyBuilder builder;
};

struct Built {
  double ms = 0;
  std::uint64_t touches = 0;
  accel::kdtree::TreeMetrics metrics{};
  scenegraph::TraceStats traced{};
  std::size_t wrong = 0;

  double work() const {
    return static_cast<double>(traced.traversal_steps) +
           1.5 * static_cast<double>(traced.triangle_tests);
  }
};

using Made = Result<std::shared_ptr<const Snapshot>>;

// The last of `repeat` full trees (they are all equal), and their median time.
Made build_full(const SceneSource& scene, const accel::published::AnyBuilder& builder, int repeat,
                Built& built) {
  std::vector<double> ms;
  std::shared_ptr<const Snapshot> last;
  for (int i = 0; i < repeat; ++i) {
    auto snapshot = assemble(scene, builder);
    if (!snapshot.ok()) return snapshot.error();
    (void)(*snapshot)->trees().static_tree();
    const Stopwatch clock;
    const auto stats = scenegraph::build_all(**snapshot);
    if (!stats.ok()) return stats.error();
    ms.push_back(clock.seconds() * 1e3);
    built.touches = stats->touches;
    last = *std::move(snapshot);
  }
  built.ms = median(ms);
  built.metrics = measure_meshes(*last);
  return last;
}

// Full trees, and trees that grow under the rays.
Result<Built> examine(StabilityFamily& family, const accel::published::AnyBuilder& builder,
                      int repeat) {
  Built built;
  const Made full = build_full(family.scene(), builder, repeat, built);
  if (!full.ok()) return full.error();
  const Made fresh = assemble(family.scene(), builder);
  if (!fresh.ok()) return fresh.error();
  std::vector<Hit> hits(family.rays().size());
  for (const auto& [snapshot, growth] :
       {std::pair(*full, Growth::kNone), {*fresh, Growth::kFirstTouch}}) {
    const auto traced =
        scenegraph::trace(*snapshot, family.rays(), hits, {.growth = growth, .surface = false});
    if (!traced.ok()) return traced.error();
    if (growth == Growth::kNone) built.traced = *traced;
    built.wrong += family.wrong(hits);
  }
  return built;
}

// Costs a triangle of the builders over a mesh without difficulties.
class CompactCosts {
 public:
  struct Cost {
    double ms = 0, touches = 0;
  };

  Result<Cost> of(const NamedBuilder& builder, std::uint64_t triangles, int repeat) {
    const std::pair key(builder.name, triangles);
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    Built built;
    const Made made = build_full(make_terrain(triangles), builder.builder, repeat, built);
    if (!made.ok()) return made.error();
    const auto n = static_cast<double>(triangles);
    return known_[key] = {built.ms / n, static_cast<double>(built.touches) / n};
  }

 private:
  std::map<std::pair<std::string, std::uint64_t>, Cost> known_;
};

double over(double value, double unit) { return unit > 0 ? value / unit : 0; }

void add_to(std::string& list, const std::string& text) {
  list += (list.empty() ? "" : "; ") + text;
}

// `measure`: the work of the reference tree; 0: there is none.
Row make_row(const StabilityFamily& family, const std::string& builder, const Built& built,
             const CompactCosts::Cost& compact, double measure) {
  const std::uint64_t triangles = family.scene().unique_triangles();
  const auto n = static_cast<double>(triangles), rays = static_cast<double>(family.rays().size());
  const double touches = over(static_cast<double>(built.touches), n);
  tests::TreeCost cost;
  cost.references = over(static_cast<double>(built.metrics.references), n);
  cost.depth = tests::levels_beyond_good(built.metrics.max_depth, triangles);
  cost.touches = over(touches, compact.touches);
  if (measure > 0) cost.work = built.work() / measure;
  cost.failed_cells = static_cast<double>(built.metrics.deferred_cells);

  std::string failures, by_design;
  if (built.wrong > 0) add_to(failures, fmt::format("{} answers wrong", built.wrong));
  for (const tests::Breach& breach : breaches(family.mesh(), builder, cost)) {
    if (breach.by_design.empty()) {
      add_to(failures, breach.text());
    } else {
      add_to(by_design, fmt::format("{}: {}", breach.text(), breach.by_design));
    }
  }
  Row row;
  row["family"] = family.mesh().name;
  row["rows"] = family.mesh().rows;
  row["builder"] = builder;
  row["triangles"] = triangles;
  row["ok"] = failures.empty();
  row["wrong"] = built.wrong;
  row["references_per_triangle"] = cost.references;
  row["max_depth"] = built.metrics.max_depth;
  row["given_up_cells"] = built.metrics.deferred_cells;
  row["touches_per_triangle"] = touches;
  row["relative_touches"] = cost.touches;
  row["bytes_peak_per_triangle"] = over(static_cast<double>(built.metrics.bytes_peak), n);
  row["build_ms"] = built.ms;
  row["relative_time"] = over(over(built.ms, n), compact.ms);
  row["steps_per_ray"] = over(static_cast<double>(built.traced.traversal_steps), rays);
  row["tests_per_ray"] = over(static_cast<double>(built.traced.triangle_tests), rays);
  row["relative_work"] = measure > 0 ? Row(cost.work) : Row(nullptr);
  row["sah_cost"] = built.metrics.sah_cost;
  row["failures"] = failures;
  row["failed_by_design"] = by_design;
  return row;
}

Result<std::vector<const HardMesh*>> chosen_meshes(const std::string& family) {
  if (const HardMesh* exactly = tests::find_hard_mesh(family)) return std::vector{exactly};
  std::vector<const HardMesh*> chosen;
  std::string known;
  for (const HardMesh& mesh : tests::hard_meshes()) {
    if (mesh.name.starts_with(family)) chosen.push_back(&mesh);
    known += fmt::format(" {}", mesh.name);
  }
  if (!chosen.empty()) return chosen;
  return Error{Code::kInvalidArgument, fmt::format("no family \"{}\"; there are:{}", family, known),
               "COMMAND_LINE"};
}

// The reference builder comes first.
Result<std::vector<NamedBuilder>> chosen_builders(const CommonOptions& common,
                                                  std::vector<std::string> names) {
  if (names.empty()) {
    for (const std::string_view name : accel::published::builder_names()) names.emplace_back(name);
  }
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return name == kMeasure; });
  std::vector<NamedBuilder> builders;
  for (const std::string& name : names) {
    const auto builder = configured_builder(name, common);
    if (!builder.ok()) return builder.error();
    builders.push_back({name, *builder});
  }
  return builders;
}

// All builders over one mesh; quadratic builders over a small one.
Status examine_mesh(const CommonOptions& common, const StabilityOptions& options,
                    const HardMesh& mesh, const std::vector<NamedBuilder>& builders,
                    CompactCosts& compact, std::vector<Row>& rows) {
  std::map<std::uint64_t, StabilityFamily> families;  // By the requested number of triangles
  std::map<std::uint64_t, double> measures;
  for (const NamedBuilder& named : builders) {
    const bool quadratic = named.name.starts_with(kQuadratic);
    const std::uint64_t size =
        quadratic ? std::min(kMostForQuadratic, options.triangles) : options.triangles;
    if (!families.contains(size)) {
      auto made = StabilityFamily::make(mesh, size, options.rays, common.seed);
      if (!made.ok()) return made.error();
      families.emplace(size, *std::move(made));
    }
    StabilityFamily& family = families.at(size);
    const auto unit = compact.of(named, size, common.repeat);
    if (!unit.ok()) return unit.error();
    const auto built = examine(family, named.builder, common.repeat);
    if (!built.ok()) return built.error();
    if (named.name == kMeasure) measures[size] = built->work();
    rows.push_back(make_row(family, named.name, *built, *unit, measures[size]));
  }
  return {};
}

}  // namespace

Result<std::vector<Row>> run_stability(const CommonOptions& common,
                                       const StabilityOptions& options) {
  const auto meshes = chosen_meshes(options.family);
  if (!meshes.ok()) return meshes.error();
  const auto builders = chosen_builders(common, options.builders);
  if (!builders.ok()) return builders.error();
  CompactCosts compact;
  std::vector<Row> rows;
  for (const HardMesh* mesh : *meshes) {
    const Status done = examine_mesh(common, options, *mesh, *builders, compact, rows);
    if (!done.ok()) return done.error();
  }
  return rows;
}

}  // namespace sightline::bench
