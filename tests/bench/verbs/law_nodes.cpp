// law --nodes: the same view of larger and larger worlds, all of them hierarchies of small meshes.
#include <fmt/core.h>
#include <tbb/task_arena.h>

#include <array>
#include <optional>

#include "accel/published/any_builder.h"
#include "tests/bench/scenes/generators.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;

constexpr int kLeastTriangles = 14, kMostTriangles = 24;  // powers of two
constexpr int kStep = 2;
constexpr std::size_t kRays = 10'000;

// Down into the first houses, which every village has, from above the corner: rays that hit nothing
// are below the ground before they reach houses that only larger villages have.
std::vector<Ray> corner_view() { return pinhole({-20, 60, -20}, {40, 0, 40}, kRays); }

struct World {
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot;
  std::size_t nodes = 0;
  std::uint64_t triangles = 0;
};

Result<World> make_world(std::uint64_t houses, const accel::published::AnyBuilder& builder,
                         accel::mesh::References references) {
  SceneSource source = make_village(houses);
  World world;
  world.nodes = source.nodes.size();
  world.triangles = source.unique_triangles();
  auto snapshot = assemble(std::move(source), builder, references);
  if (!snapshot.ok()) return snapshot.error();
  world.snapshot = std::move(snapshot).value();
  return world;
}

// The hitting ray that is nearest to the middle of the view.
Result<Ray> first_ray(const scenegraph::revision::Snapshot& snapshot,
                      const std::vector<Ray>& view) {
  std::vector<Hit> hits(view.size());
  auto traced = scenegraph::trace(snapshot, view, hits, {.surface = false});
  if (!traced.ok()) return traced.error();
  for (std::size_t i = 0; i < view.size(); ++i) {
    const std::size_t k = (view.size() / 2 + i) % view.size();
    if (hits[k].state == HitState::kHit) return view[k];
  }
  return Error{Code::kInternal, "no ray of the view hits the village", "NO_HITS"};
}

// Writes more than any cache holds.
void empty_caches() {
  constexpr std::size_t kBytes = std::size_t{256} << 20;
  static std::vector<unsigned char> junk(kBytes);
  constexpr std::size_t kCacheLine = 64;
  for (std::size_t at = 0; at < kBytes; at += kCacheLine) ++junk[at];
}

struct Timed {
  std::vector<double> first_hit_us;       // After the world was made
  std::vector<double> first_hit_cold_us;  // After the caches were emptied, too
  scenegraph::TraceStats first, all;
  std::uint64_t hits = 0;
  World world;  // Of the last repeat
};

// Every repeat makes a new world: nothing in it was used before the clock starts.
Result<Timed> measure(std::uint64_t houses, const Ray& ray, const std::vector<Ray>& view,
                      const accel::published::AnyBuilder& builder,
                      accel::mesh::References references, int repeats) {
  Timed timed;
  for (int repeat = 0; repeat < 2 * repeats; ++repeat) {
    const bool cold = repeat % 2 == 0;
    timed.world = {};
    auto world = make_world(houses, builder, references);
    if (!world.ok()) return world.error();
    timed.world = std::move(world).value();
    std::array<Hit, 1> hit;
    if (cold) empty_caches();

    const Stopwatch clock;
    auto traced = scenegraph::trace(*timed.world.snapshot, {&ray, 1}, hit, {.surface = false});
    (cold ? timed.first_hit_cold_us : timed.first_hit_us).push_back(clock.seconds() * 1e6);
    if (!traced.ok()) return traced.error();
    if (hit[0].state != HitState::kHit) {
      return Error{Code::kDataLoss, "the first ray hits in one world and misses in another",
                   "MISMATCH"};
    }
    timed.first = *traced;
  }
  timed.all = timed.first;
  std::vector<Hit> hits(view.size());
  tbb::task_arena one(1);  // Touches are the same in every run
  auto traced = one.execute(
      [&] { return scenegraph::trace(*timed.world.snapshot, view, hits, {.surface = false}); });
  if (!traced.ok()) return traced.error();
  timed.all += *traced;
  timed.hits = traced->hits;
  return timed;
}

Row make_row(const std::string& hierarchy, const Timed& timed) {
  Row row;
  row["what"] = "point";
  row["hierarchy"] = hierarchy;
  row["nodes"] = timed.world.nodes;
  row["triangles"] = timed.world.triangles;
  row["rays"] = kRays;
  row["hits"] = timed.hits;
  row["touches"] = timed.all.touches;
  row["touches_prepare"] = timed.all.touches_prepare;
  row["touches_first"] = timed.first.touches;
  row["instances_entered"] = timed.all.instances_entered;
  set_times(row, "first_hit_us", timed.first_hit_us);
  set_times(row, "first_hit_cold_us", timed.first_hit_cold_us);
  return row;
}

double quotient(const Row& above, const Row& below, const char* key) {
  return above[key].get<double>() / below[key].get<double>();
}

Row growth_row(const Row& first, const Row& last) {
  Row row;
  row["what"] = "growth";
  row["hierarchy"] = first["hierarchy"];
  for (const char* key :
       {"triangles", "touches", "touches_prepare", "first_hit_us", "first_hit_cold_us"}) {
    row[fmt::format("{}_growth", key)] = quotient(last, first, key);
  }
  return row;
}

}  // namespace

Result<std::vector<Row>> run_law_nodes(const CommonOptions& common, const LawOptions& options) {
  if (!common.scene.empty()) {
    return Error{Code::kInvalidArgument, "law --nodes has worlds of its own: no --scene", "SCENE"};
  }
  const int least = options.min_n.value_or(kLeastTriangles);
  const int most = options.max_n.value_or(std::max(least, kMostTriangles));
  const auto builder = configured_builder(options.builder, common);
  if (!builder.ok()) return builder.error();
  const std::vector<Ray> view = corner_view();

  std::vector<Row> rows, growths;
  std::vector<std::string> hierarchies = options.hierarchies;
  if (hierarchies.empty()) hierarchies = {"runs"};
  for (const std::string& hierarchy : hierarchies) {
    const auto references = parse_hierarchy(hierarchy);
    if (!references.ok()) return references.error();
    const std::size_t first_row = rows.size();
    std::optional<Ray> ray;
    for (int power = least; power <= most; power += kStep) {
      const std::uint64_t houses = (std::uint64_t{1} << power) / kTrianglesPerHouse;
      if (!ray) {
        // An untimed world warms the process and shows which ray hits.
        const auto world = make_world(houses, *builder, *references);
        if (!world.ok()) return world.error();
        const auto chosen = first_ray(*world->snapshot, view);
        if (!chosen.ok()) return chosen.error();
        ray = *chosen;
      }
      const auto timed = measure(houses, *ray, view, *builder, *references, common.repeat);
      if (!timed.ok()) return timed.error();
      rows.push_back(make_row(hierarchy, *timed));
    }
    growths.push_back(growth_row(rows[first_row], rows.back()));
  }
  for (Row& row : growths) rows.push_back(std::move(row));
  return rows;
}

}  // namespace sightline::bench
