// law: the touches of lazily grown trees, over their size and the number of triangles that rays
// see.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "accel/published/any_builder.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/law_fit.h"
#include "tests/bench/verbs/law_windows.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

constexpr int kLeastTriangles = 14, kMostTriangles = 22;  // Exponents of two
constexpr std::size_t kScattered[] = {1, 16, 256, 4096};

struct Hierarchy {
  std::string name;
  accel::mesh::References references;
};

Result<std::vector<Hierarchy>> parse_hierarchies(std::vector<std::string> names) {
  if (names.empty()) names = {"soup", "runs"};
  std::vector<Hierarchy> hierarchies;
  for (const std::string& name : names) {
    const auto references = parse_hierarchy(name);
    if (!references.ok()) return references.error();
    hierarchies.push_back({name, *references});
  }
  return hierarchies;
}

struct Task {
  const CommonOptions& common;
  const LawOptions& options;
  accel::published::AnyBuilder builder;
  std::vector<Hierarchy> hierarchies;
};

// The scene and the data that windows are drawn from.
struct Ground {
  std::string name;
  const SceneSource& scene;
  SceneGeometry geometry{scene};
  AreaSampler surface{geometry};
};

// The windows are grown in parallel, each by one thread.
Result<LawCount> measure_share(const Task& task, const Ground& ground, const Hierarchy& hierarchy,
                               double share, std::size_t& windows) {
  const auto drawn =
      law_windows(ground.geometry, ground.surface, share, task.options.windows, task.common.seed);
  windows = drawn.size();
  const LawTrees trees{&ground.scene, task.builder, hierarchy.references};
  std::vector<LawCount> counts(drawn.size());
  std::vector<std::optional<Error>> failures(drawn.size());
  tbb::parallel_for(std::size_t{0}, drawn.size(), [&](std::size_t i) {
    auto count = count_window(trees, drawn[i]);
    if (count.ok()) {
      counts[i] = *count;
    } else {
      failures[i] = count.error();
    }
  });
  for (const auto& failure : failures) {
    if (failure) return *failure;
  }
  return median_count(counts);
}

void set_counts(Row& row, const LawCount& count) {
  row["rays"] = count.rays;
  row["touches"] = count.touches;
  row["touches_prepare"] = count.touches_prepare;
  row["cells_expanded"] = count.cells_expanded;
}

Row start_row(const char* what, const Ground& ground, const Hierarchy& hierarchy) {
  Row row;
  row["what"] = what;
  row["scene"] = ground.name;
  row["hierarchy"] = hierarchy.name;
  row["n"] = ground.geometry.triangles();
  return row;
}

// One row for each share and hierarchy, from the smallest share to the whole scene.
Result<std::vector<Row>> measure_points(const Task& task, const Ground& ground) {
  std::vector<Row> rows;
  for (int power = -task.options.least_share; power <= 0; ++power) {
    for (const Hierarchy& hierarchy : task.hierarchies) {
      std::size_t windows = 0;
      const double share = std::exp2(power);
      const auto count = measure_share(task, ground, hierarchy, share, windows);
      if (!count.ok()) return count.error();
      Row row = start_row("point", ground, hierarchy);
      row["m"] = count->m;
      row["share"] = share;
      row["windows"] = windows;
      set_counts(row, *count);
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

// A cell in which one ray ends costs a pass over everything above it.
Result<std::vector<Row>> measure_scattered(const Task& task, const Ground& ground) {
  std::vector<Row> rows;
  for (const Hierarchy& hierarchy : task.hierarchies) {
    for (const std::size_t rays : kScattered) {
      const LawTrees trees{&ground.scene, task.builder, hierarchy.references};
      const auto count = count_scattered(trees, ground.geometry, rays, task.common.seed);
      if (!count.ok()) return count.error();
      Row row = start_row("sparse", ground, hierarchy);
      set_counts(row, *count);
      const double cells = static_cast<double>(count->cells_expanded);
      row["over_n_log_cells"] =
          static_cast<double>(count->touches) /
          (static_cast<double>(ground.geometry.triangles()) * std::log2(1 + cells));
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

void append(std::vector<Row>& rows, std::vector<Row> more) {
  std::move(more.begin(), more.end(), std::back_inserter(rows));
}

// Adds the law's prediction to every point.
Row fit_points(std::vector<Row>& points, const Hierarchy& hierarchy) {
  std::vector<LawPoint> law;
  for (const Row& row : points) {
    if (row["hierarchy"] != hierarchy.name) continue;
    law.push_back({row["n"], row["m"], row["touches"]});
  }
  const LawFit fit = fit_law(law);
  for (Row& row : points) {
    if (row["hierarchy"] != hierarchy.name) continue;
    const double touches = row["touches"], fitted = fit.touches(row["n"], row["m"]);
    row["fitted"] = fitted;
    row["residual"] = std::abs(fitted - touches) / touches;
  }
  Row row;
  row["what"] = "fit";
  row["hierarchy"] = hierarchy.name;
  row["points"] = law.size();
  row["a"] = fit.a;
  row["b"] = fit.b;
  row["r_squared"] = fit.r_squared;
  row["r_squared_log"] = fit.r_squared_log;
  row["max_residual"] = fit.max_residual;
  return row;
}

Result<std::vector<Row>> law_of_terrain(const Task& task) {
  const int least = task.options.min_n.value_or(kLeastTriangles);
  const int most = task.options.max_n.value_or(std::max(least, kMostTriangles));
  std::vector<Row> points, sparse;
  for (int power = least; power <= most; ++power) {
    CommonOptions common = task.common;
    common.scene = "gen:terrain?triangles=" + std::to_string(std::uint64_t{1} << power);
    const auto scene = make_scene(common);
    if (!scene.ok()) return scene.error();
    const Ground ground{common.scene, *scene};
    auto measured = measure_points(task, ground);
    if (!measured.ok()) return measured.error();
    append(points, *std::move(measured));
    if (power < most) continue;
    auto scattered = measure_scattered(task, ground);
    if (!scattered.ok()) return scattered.error();
    append(sparse, *std::move(scattered));
  }
  std::vector<Row> fits;
  for (const Hierarchy& hierarchy : task.hierarchies) {
    fits.push_back(fit_points(points, hierarchy));
  }
  append(points, std::move(sparse));
  append(points, std::move(fits));
  return points;
}

// One scene shows nothing about growth in n: runs are compared with the soup, window by window.
void compare_with_soup(std::vector<Row>& points) {
  std::map<double, Row> soup;
  for (const Row& row : points) {
    if (row["hierarchy"] == "soup") soup[row["share"]] = row;
  }
  double worst = 0, worst_in_all = 0;
  for (Row& row : points) {
    const auto base = soup.find(row["share"]);
    if (row["hierarchy"] == "soup" || base == soup.end()) continue;
    const double touches = row["touches"], prepare = row["touches_prepare"];
    const double soup_touches = base->second["touches"];
    const double soup_prepare = base->second["touches_prepare"];
    row["over_soup"] = touches / soup_touches;
    row["over_soup_in_all"] = (touches + prepare) / (soup_touches + soup_prepare);
    worst = std::max<double>(worst, row["over_soup"]);
    worst_in_all = std::max<double>(worst_in_all, row["over_soup_in_all"]);
  }
  if (worst == 0) return;
  Row row;
  row["what"] = "worst";
  row["scene"] = points.front()["scene"];
  row["hierarchy"] = "runs";
  row["over_soup"] = worst;
  row["over_soup_in_all"] = worst_in_all;
  points.push_back(std::move(row));
}

Result<std::vector<Row>> law_of_scene(const Task& task) {
  const auto scene = make_scene(task.common);
  if (!scene.ok()) return scene.error();
  const Ground ground{task.common.scene, *scene};
  if (ground.surface.empty()) {
    return Error{Code::kFailedPrecondition, "no triangle of the scene has an area", "NO_AREA"};
  }
  auto points = measure_points(task, ground);
  if (!points.ok()) return points.error();
  compare_with_soup(*points);
  auto scattered = measure_scattered(task, ground);
  if (!scattered.ok()) return scattered.error();
  append(*points, *std::move(scattered));
  return points;
}

}  // namespace

Result<std::vector<Row>> run_law(const CommonOptions& common, const LawOptions& options) {
  const auto policy = parse_policy(common.policy, scenegraph::Growth::kFirstTouch);
  if (!policy.ok()) return policy.error();
  if (*policy != scenegraph::Growth::kFirstTouch) {
    return Error{Code::kInvalidArgument, "law is measured with policy first-touch", "POLICY"};
  }
  const auto builder = configured_builder(options.builder, common);
  if (!builder.ok()) return builder.error();
  if (accel::mesh::TreeBuilder(*builder).whole != nullptr) {
    return Error{Code::kInvalidArgument,
                 options.builder + ": trees that are built whole have no law", "COMMAND_LINE"};
  }
  const auto hierarchies = parse_hierarchies(options.hierarchies);
  if (!hierarchies.ok()) return hierarchies.error();
  const Task task{common, options, *builder, *hierarchies};
  return common.scene.empty() ? law_of_terrain(task) : law_of_scene(task);
}

}  // namespace sightline::bench
