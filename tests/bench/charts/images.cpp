// How long a picture of a given number of rays takes, from arrays to hits.
#include "tests/bench/charts/images.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "tests/bench/charts/pictures.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

constexpr std::array<std::string_view, 2> kPictures{"overview", "closeup"};

struct WayName {
  std::string_view builder;
  bool grows = false;
};
constexpr std::array<WayName, 9> kWays{{{"scan-fast", true},
                                        {"scan-fast"},
                                        {"scan-one-axis"},
                                        {"scan-best"},
                                        {"bvh-binned"},
                                        {"sbvh"},
                                        {"embree-low"},
                                        {"embree-medium"},
                                        {"embree-high"}}};

// Number of rays with which Embree's entry point is chosen (fewer if no picture has as many).
constexpr std::size_t kChoosingRays = 10'000;

// A way of building, and its times for each picture.
struct Way {
  Contender contender;
  bool grows = false;
  std::unique_ptr<EmbreePeer> peer;  // Embree only
  std::vector<std::vector<double>> seconds;
  double one_more_ray = 0;  // seconds, with the largest picture's trees
};

std::vector<Way> all_ways(std::size_t pictures) {
  std::vector<Way> ways;
  for (const WayName& name : kWays) {
    // The configurations have already reported what this program does not have.
    if (parse_embree(name.builder) && !embree_found()) continue;
    auto found = parse_contenders({std::string(name.builder)}, {});
    if (!found.ok()) continue;
    Way way{std::move(found->front()), name.grows, nullptr, {}};
    way.seconds.resize(pictures);
    ways.push_back(std::move(way));
  }
  return ways;
}

Result<double> trace_picture(const scenegraph::revision::Snapshot& snapshot,
                             const ChartPicture& picture) {
  std::vector<accel::geometry::Hit> hits(picture.rays.size());
  const Stopwatch clock;
  auto traced = scenegraph::trace(snapshot, picture.rays, hits, {.surface = false});
  const double seconds = clock.seconds();
  if (!traced.ok()) return traced.error();
  if (const std::string hash = hit_hash(hits, scenegraph::QueryKind::kClosest);
      hash != picture.hash) {
    return Error{Code::kDataLoss,
                 "answers (" + hash + ") differ from those of full trees (" + picture.hash + ")",
                 "HASHES_DIFFER"};
  }
  return seconds;
}

class Gallery {
 public:
  Gallery(const SceneSource& scene, const std::vector<ChartPicture>& pictures, int threads)
      : scene_(scene), pictures_(pictures), threads_(threads) {}

  /// Traces all pictures once; the largest one only if `largest`.
  Status run(Way& way, bool largest) const {
    const std::size_t count = pictures_.size() - (largest ? 0 : 1);
    if (way.contender.embree() != nullptr) return run_embree(way, count);
    return way.grows ? run_growing(way, count) : run_full(way, count);
  }

 private:
  bool is_largest(std::size_t picture) const { return picture + 1 == pictures_.size(); }
  // For the largest picture.
  double seconds_a_ray(double seconds) const {
    return seconds / static_cast<double>(pictures_.back().rays.size());
  }

  // Meshes are checked and bounded inside the clock.
  Status run_full(Way& way, std::size_t count) const {
    SceneSource arrays = scene_;
    const Stopwatch clock;
    auto snapshot = assemble(std::move(arrays), *way.contender.ours());
    if (!snapshot.ok()) return snapshot.error();
    if (auto built = scenegraph::build_all(**snapshot); !built.ok()) return built.error();
    const double before_rays = clock.seconds();
    for (std::size_t p = 0; p < count; ++p) {
      const auto traced = trace_picture(**snapshot, pictures_[p]);
      if (!traced.ok()) return traced.error();
      way.seconds[p].push_back(before_rays + *traced);
      if (is_largest(p)) way.one_more_ray = seconds_a_ray(*traced);
    }
    return {};
  }

  // Every picture starts without any tree.
  Status run_growing(Way& way, std::size_t count) const {
    for (std::size_t p = 0; p < count; ++p) {
      SceneSource arrays = scene_;
      const Stopwatch clock;
      auto snapshot = assemble(std::move(arrays), *way.contender.ours());
      if (!snapshot.ok()) return snapshot.error();
      const double before_rays = clock.seconds();
      const auto traced = trace_picture(**snapshot, pictures_[p]);
      if (!traced.ok()) return traced.error();
      way.seconds[p].push_back(before_rays + *traced);
      if (!is_largest(p)) continue;
      const auto again = trace_picture(**snapshot, pictures_[p]);
      if (!again.ok()) return again.error();
      way.one_more_ray = seconds_a_ray(*again);
    }
    return {};
  }

  // Rays are written into Embree's own layout outside the clock.
  Status run_embree(Way& way, std::size_t count) const {
    const bool first = !way.peer;
    if (first) {
      auto made = EmbreePeer::make(scene_, *way.contender.embree(), threads_);
      if (!made.ok()) return made.error();
      way.peer = *std::move(made);
      if (auto warm = way.peer->build(); !warm.ok()) return warm.error();
    }
    const auto built = way.peer->build();
    if (!built.ok()) return built.error();
    if (first) {
      const auto enough = std::find_if(
          pictures_.begin(), pictures_.end() - 1,
          [](const ChartPicture& picture) { return picture.rays.size() >= kChoosingRays; });
      way.peer->choose_entry(enough->rays, false);
    }
    for (std::size_t p = 0; p < count; ++p) {
      std::vector<accel::geometry::Hit> hits(pictures_[p].rays.size());
      const double traced = way.peer->trace(pictures_[p].rays, false, hits, 0);
      way.seconds[p].push_back(built->total_seconds + traced);
      if (is_largest(p)) way.one_more_ray = seconds_a_ray(traced);
    }
    return {};
  }

  const SceneSource& scene_;
  const std::vector<ChartPicture>& pictures_;
  int threads_;
};

Row image_row(const ChartScene& scene, std::string_view kind, const Way& way, std::size_t count) {
  Row row;
  row["study"] = "image";
  row["scene"] = scene.name;
  row["triangles"] = scene.scene.unique_triangles();
  row["builder"] = row["configuration"] = way.contender.name;
  row["policy"] = way.grows ? "first-touch" : "full";
  row["rays"] = kind;
  row["count"] = count;
  return row;
}

void add_rows(const ChartScene& scene, std::string_view kind, const Way& way, const ChartPlan& plan,
              std::vector<Row>& rows) {
  std::size_t count = 1;
  for (const std::vector<double>& seconds : way.seconds) {
    Row row = image_row(scene, kind, way, count);
    row["rounds"] = seconds.size();
    row["basis"] = "measured";
    set_times(row, "seconds_to_hits", seconds);
    rows.push_back(std::move(row));
    count *= 10;
  }
  const std::size_t traced = count / 10;
  for (; count <= plan.largest_extrapolated; count *= 10) {
    Row row = image_row(scene, kind, way, count);
    row["rounds"] = way.seconds.back().size();
    row["basis"] = "extrapolated";
    row["seconds_to_hits"] =
        median(way.seconds.back()) + static_cast<double>(count - traced) * way.one_more_ray;
    rows.push_back(std::move(row));
  }
}

}  // namespace

Result<std::vector<Row>> chart_images(const ChartScene& scene, const CommonOptions& common,
                                      const ChartPlan& plan) {
  std::vector<Row> rows;
  for (const std::string_view kind : kPictures) {
    const auto pictures = chart_pictures(scene.scene, kind, common.seed, plan);
    if (!pictures.ok()) return pictures.error();
    const Gallery gallery(scene.scene, *pictures, common.threads);
    std::vector<Way> ways = all_ways(pictures->size());
    for (int round = 0; round < common.repeat; ++round) {
      for (std::size_t i = 0; i < ways.size(); ++i) {
        Way& way = ways[round % 2 == 0 ? i : ways.size() - 1 - i];
        if (auto done = gallery.run(way, round == 0); !done.ok()) {
          return Error{done.error().code, way.contender.name + ": " + done.error().message,
                       done.error().reason};
        }
      }
    }
    for (const Way& way : ways) add_rows(scene, kind, way, plan, rows);
  }
  return rows;
}

}  // namespace sightline::bench
