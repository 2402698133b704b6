// answers: traces the same rays in every possible way and hashes the answers of each way.
#include <fmt/core.h>
#include <hwy/highway.h>
#include <tbb/task_arena.h>

#include <array>
#include <cstdio>

#include "accel/published/any_builder.h"
#include "tests/bench/scenes/ray_orders.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/on_target.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using scenegraph::Growth;
using scenegraph::QueryKind;
using scenegraph::RayTally;
using tests::OnTarget;
using SnapshotPtr = std::shared_ptr<const scenegraph::revision::Snapshot>;

constexpr std::array<int, 3> kThreads{1, 2, kMostAnswerThreads};
// Rays a batch; 0: all in one.
constexpr std::array<std::size_t, 4> kBatches{0, 8192, 777, 64};
// The quadratic builder takes hours on larger scenes.
constexpr std::uint64_t kMostNaive = 25'000;

// One way to answer.
struct Way {
  std::string builder;
  Growth growth = Growth::kFull;
  int threads = 1;
  std::string_view order;
  std::size_t batch = 0;
  std::int64_t target = 0;
};

// By kind, in the order of the enumeration. Equal hashes mean equal answer columns of all rays.
using Hashes = std::array<std::string, 4>;

struct Workload {
  const SceneSource& scene;
  const std::vector<Ray>& rays;
};

// One fingerprint a ray, so that the order of answering does not matter.
class Prints {
 public:
  explicit Prints(std::size_t rays) : of_ray_(rays) {}
  Fingerprint& operator[](std::size_t ray) { return of_ray_[ray]; }
  std::string text() const {
    Fingerprint all;
    for (const Fingerprint& print : of_ray_) all.add(print.value());
    return all.text();
  }

 private:
  std::vector<Fingerprint> of_ray_;
};

// Answers one batch, whose rays have these indices, in one of the four kinds.
Status answer(const scenegraph::revision::Snapshot& snapshot, std::span<const Ray> rays,
              std::span<const std::size_t> indices, QueryKind kind, Prints& prints) {
  const scenegraph::TraceOptions options{.kind = kind};
  std::vector<Hit> hits;
  std::vector<RayTally> tallies(rays.size());
  Result<scenegraph::TraceStats> done = scenegraph::TraceStats{};
  switch (kind) {
    case QueryKind::kClosest:
    case QueryKind::kAny:
      hits.resize(rays.size());
      done = scenegraph::trace(snapshot, rays, hits, options);
      break;
    case QueryKind::kCount:
      done = scenegraph::count_hits(snapshot, rays, tallies, options);
      break;
    case QueryKind::kAll:
      done = scenegraph::list_hits(snapshot, rays, tallies, hits, options);
      break;
  }
  if (!done.ok()) return done.error();
  std::size_t next = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Fingerprint& print = prints[indices[i]];
    if (kind == QueryKind::kClosest) print.add_columns(hits[i]);
    if (kind == QueryKind::kAny) print.add(static_cast<std::uint64_t>(hits[i].state), 1);
    if (kind != QueryKind::kCount && kind != QueryKind::kAll) continue;
    print.add(tallies[i].count);
    print.add(static_cast<std::uint64_t>(tallies[i].state), 1);
    for (std::uint32_t k = 0; kind == QueryKind::kAll && k < tallies[i].count; ++k) {
      print.add_columns(hits[next++]);
    }
  }
  return {};
}

Result<SnapshotPtr> begin(const Workload& work, const Way& way, const CommonOptions& common) {
  const auto builder = configured_builder(way.builder, common);
  if (!builder.ok()) return builder.error();
  auto snapshot = assemble(work.scene, *builder);
  if (!snapshot.ok() || way.growth != Growth::kFull) return snapshot;
  if (const auto built = scenegraph::build_all(**snapshot); !built.ok()) return built.error();
  return snapshot;
}

// Growing trees are made anew for every kind; full trees are the given ones.
Result<Hashes> answer_all(const Workload& work, const Way& way, const CommonOptions& common,
                          const SnapshotPtr& full) {
  const std::vector<std::size_t> order = ray_order(way.order, work.rays);
  std::vector<Ray> rays;
  rays.reserve(order.size());
  for (const std::size_t i : order) rays.push_back(work.rays[i]);
  const std::size_t batch = way.batch == 0 ? rays.size() : way.batch;
  Hashes hashes;
  for (std::size_t kind = 0; kind < hashes.size(); ++kind) {
    Result<SnapshotPtr> snapshot = full;
    if (!full) snapshot = begin(work, way, common);
    if (!snapshot.ok()) return snapshot.error();
    Prints prints(rays.size());
    for (std::size_t first = 0; first < rays.size(); first += batch) {
      const std::size_t count = std::min(batch, rays.size() - first);
      const Status done =
          answer(**snapshot, std::span(rays).subspan(first, count),
                 std::span(order).subspan(first, count), static_cast<QueryKind>(kind), prints);
      if (!done.ok()) return done.error();
    }
    hashes[kind] = prints.text();
  }
  return hashes;
}

class Run {
 public:
  Run(const Workload& work, const CommonOptions& common) : work_(work), common_(common) {}

  /// Answers in all ways that share builder, growth, threads and target.
  Status run(const std::vector<Way>& ways) {
    const OnTarget target(ways.front().target);
    tbb::task_arena arena(ways.front().threads);
    return arena.execute([&]() -> Status {
      SnapshotPtr full;
      if (ways.front().growth == Growth::kFull) {
        auto built = begin(work_, ways.front(), common_);
        if (!built.ok()) return built.error();
        full = *std::move(built);
      }
      for (const Way& way : ways) {
        auto hashes = answer_all(work_, way, common_, full);
        if (!hashes.ok()) return hashes.error();
        note(way, *hashes);
      }
      return {};
    });
  }

  Result<std::vector<Row>> rows() && {
    if (differing_.empty()) return std::move(rows_);
    return Error{Code::kDataLoss, "answers differ from those of the first way:" + differing_,
                 "HASHES_DIFFER"};
  }

 private:
  void note(const Way& way, const Hashes& hashes) {
    Row row;
    row["builder"] = way.builder;
    row["policy"] = policy_name(way.growth);
    row["threads"] = way.threads;
    row["order"] = way.order;
    row["batch"] = way.batch == 0 ? work_.rays.size() : way.batch;
    row["simd"] = hwy::TargetName(way.target);
    row["rays"] = work_.rays.size();
    row["closest"] = hashes[0];
    row["any"] = hashes[1];
    row["count"] = hashes[2];
    row["all"] = hashes[3];
    if (rows_.empty()) first_ = hashes;
    if (hashes != first_) differing_ += "\n" + row.dump();
    rows_.push_back(std::move(row));
  }

  const Workload& work_;
  const CommonOptions& common_;
  std::vector<Row> rows_;
  Hashes first_;
  std::string differing_;
};

std::vector<std::string> builders_for(const SceneSource& scene, const AnswersOptions& options) {
  if (!options.builders.empty()) return options.builders;
  std::vector<std::string> names;
  for (const std::string_view name : accel::published::builder_names()) {
    if (name == "sah-naive" && scene.unique_triangles() > kMostNaive) {
      fmt::print(stderr, "sightline-bench: no rows for sah-naive: over {} triangles\n", kMostNaive);
      continue;
    }
    names.emplace_back(name);
  }
  return names;
}

// All builders on all targets, then the default builder with all numbers of threads, orders and
// splits; each with full trees, and with growing ones, by first touch and by demand.
std::vector<std::vector<Way>> all_ways(const SceneSource& scene, const AnswersOptions& options,
                                       int threads) {
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  std::vector<std::vector<Way>> ways;
  for (const Growth growth : {Growth::kFull, Growth::kFirstTouch, Growth::kDemand}) {
    for (const std::string& builder : builders_for(scene, options)) {
      for (const std::int64_t target : targets) {
        ways.push_back({{builder, growth, threads, "as-made", 0, target}});
      }
    }
    for (const int some : kThreads) {
      auto& group = ways.emplace_back();
      for (const std::string_view order : ray_order_names()) {
        for (const std::size_t batch : kBatches) {
          group.push_back({"scan-fast", growth, some, order, batch, targets.front()});
        }
      }
    }
  }
  return ways;
}

}  // namespace

Result<std::vector<Row>> run_answers(const CommonOptions& common, const AnswersOptions& options) {
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  std::vector<Ray> rays;
  for (const std::string& kind : options.kinds) {
    const auto some = make_rays(*scene, RayOptions{kind, options.count}, common.seed);
    if (!some.ok()) return some.error();
    rays.insert(rays.end(), some->begin(), some->end());
  }
  const Workload work{*scene, rays};
  Run run(work, common);
  for (const std::vector<Way>& ways : all_ways(*scene, options, common.threads)) {
    if (auto done = run.run(ways); !done.ok()) return done.error();
  }
  return std::move(run).rows();
}

}  // namespace sightline::bench
