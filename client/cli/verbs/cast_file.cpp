// One stream for a file; one for each burst of rays that come line by line.
#include "client/cli/verbs/cast_file.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>
#include <variant>

#include "client/cli/files/hit_file.h"
#include "client/cli/files/hit_rows.h"
#include "client/cli/files/point_limit.h"
#include "client/cli/files/ray_file.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/origin_precision.h"
#include "client/cli/verbs/prefetch.h"

namespace sightline::client::cli::verbs {
namespace {

// Adds the cost of trees that were built before the cast.
void add_building(const PrefetchReport& built, CastReport& cast) {
  cast.cells_expanded += built.cells_expanded;
  cast.build_us += built.build_us;
  cast.trace_us += built.elapsed_us;
}

/// A value of `inside`.
constexpr std::uint8_t kInside = 1;

// Writes answers to the file.
class AnswerWriter {
 public:
  AnswerWriter(files::HitFile& file, bool lists, RaysOnTheirWay* rays)
      : file_(file), lists_(lists), rays_(rays) {}

  Status write(std::uint64_t first, std::size_t count, const HitView& answers) {
    const std::uint64_t number = base_ + first;
    if (lists_) {
      files::RowView listed = rows_.make(number, answers);
      return write_rows(listed, rows_.size(), number, number + count);
    }
    inside_ += static_cast<std::uint64_t>(
        std::count(answers.inside.begin(), answers.inside.end(), kInside));
    files::RowView rows(answers);
    return write_rows(rows, count, number, number + count);
  }

  /// The next stream counts its rays from here.
  void set_base(std::uint64_t base) { base_ = base; }

  /// The points that are inside, if that was asked.
  std::uint64_t inside() const { return inside_; }

 private:
  Status write_rows(files::RowView& rows, std::size_t n, std::uint64_t first, std::uint64_t end) {
    if (rays_ != nullptr) {
      add_lines(rows, n, first);
      rays_->forget_before(end);
    }
    return file_.write(rows, n);
  }

  void add_lines(files::RowView& rows, std::size_t n, std::uint64_t first) {
    lines_.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const auto ray = rays_->at(rows.ray.empty() ? first + i : rows.ray[i]);
      lines_.insert(lines_.end(), ray.origin.begin(), ray.origin.end());
      lines_.insert(lines_.end(), ray.direction.begin(), ray.direction.end());
    }
    rows.lines = lines_;
  }

  files::HitFile& file_;
  const bool lists_;
  RaysOnTheirWay* const rays_;
  std::uint64_t base_ = 0;
  std::uint64_t inside_ = 0;
  files::HitRows rows_;
  std::vector<double> lines_;
};

Result<files::HitFile> open_hits(const CastFileRequest& request, const files::RayFile& rays) {
  files::HitFileOptions options{
      .format = request.out_format, .names = request.names, .asked = request.asked};
  const bool lists = request.options.kind == QueryKind::kAll;
  if (!lists) {
    options.rows = rays.count;
    options.array_shape = rays.array_shape;
  }
  return files::HitFile::open(request.out, request.columns, options);
}

struct Cast {
  const Client& client;
  const CastRequest& request;
  files::RayFile& rays;
  AnswerWriter& writer;

  Result<CastReport> run() const {
    const bool has_points = request.asked == files::RowKind::kPoints;
    const auto unit = has_points ? ProgressBar::Unit::kPoints : ProgressBar::Unit::kRays;
    ProgressBar bar(has_points ? "measuring" : "casting");
    CastReport sum;
    const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& answers) {
      if (rays.count && *rays.count > 0) bar.update_amount(first + count, *rays.count, unit);
      return writer.write(first, count, answers);
    };
    // Without any ray, one stream says whether the request is good.
    for (bool begun = false;; begun = true) {
      const auto more = rays.wait ? rays.wait() : Result<bool>(!begun);
      if (!more) return more.error();
      if (begun && !*more) return sum;
      writer.set_base(sum.rays);
      const auto part =
          std::visit([&](const auto& source) { return ask(source, sink); }, rays.source);
      if (!part) return part.error();
      add(*part, sum);
    }
  }

 private:
  template <class Scalar>
  Result<CastReport> ask(const RaySource<Scalar>& source, const HitSink& sink) const {
    if (request.asked == files::RowKind::kRays) {
      return client.cast_stream(request.scene, source, rays.shape, request.fields, sink,
                                request.options);
    }
    return client.nearest_stream(request.scene, files::as_points(source),
                                 {.max_distance = rays.shape.interval, .masks = rays.shape.masks},
                                 request.fields, sink, request.options);
  }
};

// Looks at the rays on their way.
void watch(files::RayFile& rays, CastOutcome& outcome) {
  if (auto* const floats = std::get_if<RaySource<float>>(&rays.source)) {
    *floats = watched(watch_reach(std::move(*floats), outcome.float_reach), outcome.watch);
  } else {
    auto& doubles = std::get<RaySource<double>>(rays.source);
    doubles = watched(std::move(doubles), outcome.watch);
  }
}

}  // namespace

void add(const CastReport& part, CastReport& sum) {
  sum.revision = part.revision;
  sum.token = part.token;
  sum.rays += part.rays;
  sum.hits += part.hits;
  sum.invalid += part.invalid;
  sum.unanswered += part.unanswered;
  sum.hits_found += part.hits_found;
  sum.rays_cut_off += part.rays_cut_off;
  sum.traversal_steps += part.traversal_steps;
  sum.triangle_tests += part.triangle_tests;
  sum.instances_entered += part.instances_entered;
  sum.cells_expanded += part.cells_expanded;
  sum.queue_us += part.queue_us;
  sum.build_us += part.build_us;
  sum.trace_us += part.trace_us;
}

Result<CastOutcome> cast_file(const Client& client, const CastFileRequest& request) {
  auto rays = files::open_rows(request.in, request.asked, request.options.stop);
  if (!rays) return rays.error();
  auto hits = open_hits(request, *rays);
  if (!hits) return hits.error();
  CastRequest cast{.scene = request.scene,
                   .fields = files::fields_for(request.columns),
                   .options = request.options,
                   .asked = request.asked,
                   .max_distance = request.max_distance};
  if (!request.updates) return cast_rays(client, cast, *std::move(rays), *std::move(hits));
  auto applied = client.apply(request.scene, *request.updates);
  if (!applied) return applied.error();
  cast.options.consistency.exact_revision = applied->revision;
  auto outcome = cast_rays(client, cast, *std::move(rays), *std::move(hits));
  if (outcome) outcome->applied = *std::move(applied);
  return outcome;
}

Result<CastOutcome> cast_rays(const Client& client, CastRequest request, files::RayFile rays,
                              files::HitFile hits) {
  const CastOptions& options = request.options;
  CastOutcome outcome;
  outcome.asked = request.asked;
  RaysOnTheirWay on_their_way;
  if (hits.needs_lines()) {
    outcome.watch.on_their_way = &on_their_way;
    request.fields.t = true;
  }
  watch(rays, outcome);
  if (request.max_distance) files::limit_distances(rays, *request.max_distance);
  outcome.looks_for_faces = !request.fields.are_sides_alone();
  const auto start = std::chrono::steady_clock::now();
  PrefetchReport built;
  if (options.build == BuildMode::kFull) {
    const auto all = build_all(client, request.scene, options.stop);
    if (!all) return all.error();
    built = *all;
  }
  AnswerWriter writer(hits, options.kind == QueryKind::kAll, outcome.watch.on_their_way);
  auto report = Cast{client, request, rays, writer}.run();
  outcome.watch.on_their_way = nullptr;
  if (!report) return report.error();
  outcome.cast = *report;
  if (request.fields.inside) outcome.inside = writer.inside();
  add_building(built, outcome.cast);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  outcome.seconds = seconds.count();
  if (const Status wrote = hits.commit(); !wrote) return wrote.error();
  return outcome;
}

}  // namespace sightline::client::cli::verbs
