// clusters: the memory of trees over clustered triangles, and what rays pay in them.
#include <fmt/core.h>

#include <string>
#include <vector>

#include "accel/published/any_builder.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/memory_peak.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/support/hard_clusters.h"
#include "tests/support/hard_meshes.h"

namespace sightline::bench {
namespace {

using tests::AskedTree;
using tests::NearestHit;
using tests::TestMesh;

struct Kind {
  std::string_view name;
  TestMesh (*make)(std::uint32_t triangles, std::uint64_t seed);
};

/// The mesh without difficulties comes first.
std::vector<Kind> all_kinds() {
  std::vector<Kind> kinds{{"compact", tests::find_hard_mesh("compact")->make}};
  for (const tests::ClusteredMesh& mesh : tests::clustered_meshes())
    kinds.push_back({mesh.name, mesh.make});
  for (const std::string_view name : {"slivers", "rods", "fan"})
    kinds.push_back({name, tests::find_hard_mesh(name)->make});
  return kinds;
}

Result<std::vector<Kind>> chosen_kinds(const std::string& name) {
  std::vector<Kind> chosen;
  std::string known;
  for (const Kind& kind : all_kinds()) {
    if (kind.name == "compact" || name.empty() || name == kind.name) chosen.push_back(kind);
    known += fmt::format(" {}", kind.name);
  }
  if (chosen.size() > 1 || name == "compact") return chosen;
  return Error{Code::kInvalidArgument, fmt::format("no kind \"{}\"; there are:{}", name, known),
               "COMMAND_LINE"};
}

std::vector<NearestHit> ask(AskedTree& tree, const std::vector<accel::geometry::Ray>& rays) {
  std::vector<NearestHit> hits;
  for (const accel::geometry::Ray& ray : rays) hits.push_back(tree.nearest(ray));
  return hits;
}

/// A tree that is built, and one that grows under the rays.
Row measure(const Kind& kind, const accel::mesh::TreeBuilder& builder,
            const ClusterOptions& options, std::uint64_t seed) {
  const TestMesh mesh = kind.make(static_cast<std::uint32_t>(options.triangles), seed);
  const std::vector<accel::geometry::Ray> rays = tests::rays_at(mesh, options.rays, seed);
  const auto n = static_cast<double>(mesh.faces.size());
  Row row;
  row["kind"] = kind.name;
  row["triangles"] = mesh.faces.size();
  std::vector<NearestHit> hits;
  {
    AskedTree growing(mesh, builder);
    const MemoryPeak resident;
    hits = ask(growing, rays);
    if (const auto bytes = resident.bytes())
      row["resident_peak_growing"] = static_cast<double>(*bytes) / n;
    row["peak_growing"] = static_cast<double>(growing.metrics().bytes_peak) / n;
  }
  AskedTree full(mesh, builder);
  const MemoryPeak resident;
  full.build();
  if (const auto bytes = resident.bytes())
    row["resident_peak_full"] = static_cast<double>(*bytes) / n;
  const accel::kdtree::TreeMetrics metrics = full.metrics();
  row["peak_full"] = static_cast<double>(metrics.bytes_peak) / n;
  row["final"] = static_cast<double>(metrics.bytes) / n;
  row["references_per_triangle"] = static_cast<double>(metrics.references) / n;
  row["touches_per_triangle"] = static_cast<double>(full.built().touches) / n;
  std::size_t wrong = 0;
  const std::vector<NearestHit> again = ask(full, rays);
  for (std::size_t i = 0; i < hits.size(); ++i) wrong += hits[i] == again[i] ? 0 : 1;
  row["wrong"] = wrong;
  row["steps_per_ray"] =
      static_cast<double>(full.walked().steps) / static_cast<double>(rays.size());
  row["tests_per_ray"] =
      static_cast<double>(full.walked().tests) / static_cast<double>(rays.size());
  return row;
}

double work(const Row& row) {
  return row["steps_per_ray"].get<double>() + 1.5 * row["tests_per_ray"].get<double>();
}

}  // namespace

Result<std::vector<Row>> run_clusters(const CommonOptions& common, const ClusterOptions& options) {
  const auto kinds = chosen_kinds(options.kind);
  if (!kinds.ok()) return kinds.error();
  const auto builder = configured_builder(options.builder, common);
  if (!builder.ok()) return builder.error();
  std::vector<Row> rows;
  for (const Kind& kind : *kinds) {
    rows.push_back(measure(kind, *builder, options, common.seed));
    rows.back()["builder"] = options.builder;
    rows.back()["relative_work"] = work(rows.back()) / work(rows.front());
  }
  return rows;
}

}  // namespace sightline::bench
