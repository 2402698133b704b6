// exactness: the cost of the exact hit rule compared with a plain float test in the same walk.
#include <algorithm>
#include <array>
#include <limits>

#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/disagreement.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/kernel_walk.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

constexpr scenegraph::QueryKind kClosest = scenegraph::QueryKind::kClosest;

// Rays are timed in chunks, with all methods in turn on each chunk: other load on the machine
// affects all methods, and the least time of a chunk is free of it.
constexpr std::size_t kRaysPerChunk = 32 * scenegraph::kRaysPerBlock;

enum Method : std::size_t { kProduct, kExact, kPlain, kMethods };

struct Timed {
  const scenegraph::revision::Snapshot& snapshot;
  std::span<const accel::geometry::Ray> rays;
  std::array<std::vector<accel::geometry::Hit>, kMethods> hits;
  std::array<std::vector<double>, kMethods> least;  // Seconds, by chunk

  Timed(const scenegraph::revision::Snapshot& s, std::span<const accel::geometry::Ray> r)
      : snapshot(s), rays(r) {
    const std::size_t chunks = (rays.size() + kRaysPerChunk - 1) / kRaysPerChunk;
    for (std::size_t m = 0; m < kMethods; ++m) {
      hits[m].resize(rays.size());
      least[m].assign(chunks, std::numeric_limits<double>::infinity());
    }
  }

  void run_method(Method method, std::size_t first, std::size_t count) {
    const auto some_rays = rays.subspan(first, count);
    const auto some_hits = std::span(hits[method]).subspan(first, count);
    if (method == kProduct) {
      (void)scenegraph::trace(snapshot, some_rays, some_hits, {.surface = false});
    } else {
      trace_closest(snapshot.trees().static_tree(),
                    method == kExact ? TriangleTest::kExact : TriangleTest::kPlainFloat, some_rays,
                    some_hits);
    }
  }

  // The order rotates from round to round.
  void run(std::size_t round) {
    for (std::size_t s = 0; s < least[0].size(); ++s) {
      const std::size_t first = s * kRaysPerChunk,
                        count = std::min(kRaysPerChunk, rays.size() - first);
      for (std::size_t k = 0; k < kMethods; ++k) {
        const auto method = static_cast<Method>((k + s + round) % kMethods);
        const Stopwatch clock;
        run_method(method, first, count);
        least[method][s] = std::min(least[method][s], clock.seconds());
      }
    }
  }

  double milliseconds(Method method) const {
    double sum = 0;
    for (const double seconds : least[method]) sum += seconds;
    return sum * 1e3;
  }
};

Result<Row> measure(const CommonOptions& common, const ExactnessOptions& options,
                    const SceneSource& scene, const std::string& kind) {
  const auto rays = make_rays(scene, RayOptions{kind, options.count}, common.seed);
  if (!rays.ok()) return rays.error();
  const auto builder = configured_builder(options.builder, common);
  if (!builder.ok()) return builder.error();
  const auto snapshot = assemble(scene, *builder);
  if (!snapshot.ok()) return snapshot.error();
  if (const auto built = scenegraph::build_all(**snapshot); !built.ok()) return built.error();
  const auto check = AnswerCheck::make(scene, *rays, kClosest);
  if (!check.ok()) return check.error();

  Timed timed(**snapshot, *rays);
  for (std::size_t round = 0; round <= static_cast<std::size_t>(common.repeat); ++round) {
    timed.run(round);
  }
  if (auto right = (*check)(timed.hits[kProduct]); !right.ok()) return right.error();
  const std::string hash = hit_hash(timed.hits[kProduct], kClosest);
  if (hit_hash(timed.hits[kExact], kClosest) != hash) {
    return Error{Code::kDataLoss, "the bench's walk answers otherwise than the product's",
                 "HASHES_DIFFER"};
  }
  const Disagreement difference =
      explain(*snapshot, *rays, timed.hits[kProduct], timed.hits[kPlain], false);

  Row row;
  row["scene"] = common.scene;
  row["rays"] = kind;
  row["count"] = rays->size();
  row["threads"] = common.threads;
  row["product_ms"] = timed.milliseconds(kProduct);
  row["exact_ms"] = timed.milliseconds(kExact);
  row["plain_float_ms"] = timed.milliseconds(kPlain);
  row["ratio"] = timed.milliseconds(kExact) / timed.milliseconds(kPlain);
  row["ratio_product"] = timed.milliseconds(kProduct) / timed.milliseconds(kPlain);
  row["hit_hash"] = hash;
  row["differences"] = difference.differences;
  row["differences_checked"] = difference.checked;
  row["unexplained"] = difference.unexplained;
  return row;
}

}  // namespace

Result<std::vector<Row>> run_exactness(const CommonOptions& common,
                                       const ExactnessOptions& options) {
  const auto builder = configured_builder(options.builder, common);
  if (!builder.ok()) return builder.error();
  if (accel::mesh::TreeBuilder(*builder).whole != nullptr) {
    return Error{Code::kInvalidArgument,
                 options.builder + ": exactness walks the product's trees; for others, see trace",
                 "COMMAND_LINE"};
  }
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  std::vector<Row> rows;
  for (const std::string& kind : options.kinds) {
    auto row = measure(common, options, *scene, kind);
    if (!row.ok()) return row.error();
    rows.push_back(*std::move(row));
  }
  return rows;
}

}  // namespace sightline::bench
