// Points are made of the hits while they are sent, so that a picture holds two numbers for each and
// no positions.
#include "client/cli/picture/clearance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "client/cli/picture/shading.h"
#include "client/cli/picture/view_cast.h"

namespace sightline::client::cli::picture {
namespace {

constexpr float kMiss = -1;  // as the light of a sample

// Walks the samples that have hit, in order.
class HitWalk {
 public:
  explicit HitWalk(const std::vector<Sample>& samples) : samples_(samples) {}

  bool has_next() {
    while (next_ < samples_.size() && samples_[next_].light < 0) ++next_;
    return next_ < samples_.size();
  }
  // Call it if has_next().
  std::size_t next() { return next_++; }

 private:
  const std::vector<Sample>& samples_;
  std::size_t next_ = 0;
};

class ClearancePainter {
 public:
  ClearancePainter(const Client& client, const SceneInfo& scene, Film& film,
                   const ClearanceRequest& request, const std::function<void(double)>& progress)
      : client_(client),
        scene_(scene),
        film_(film),
        request_(request),
        progress_(progress),
        samples_(film.samples(), Sample{.light = kMiss}),
        depths_(film.samples()) {}

  Status cast(const Consistency& consistency) {
    const CastOptions options{.root = request_.node, .consistency = consistency};
    const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
      for (std::size_t row = 0; row < count; ++row) see(first + row, hits, row);
      progress_(0.5 * part(first + count, film_.samples()));
      return Status();
    };
    HitFields fields;
    fields.t = fields.hit = fields.normal = true;
    auto cast = cast_view(client_, scene_.name, film_, {0, film_.samples()}, fields, sink, options);
    if (!cast) return cast.error();
    report_ = *std::move(cast);
    return {};
  }

  Status measure() {
    if (report_.hits == 0) return {};
    HitWalk asked(samples_), answered(samples_);
    const PointSource<double> source =
        [&](const PointColumns<double>& buffer) -> Result<std::size_t> {
      std::size_t rows = 0;
      for (; rows < kRaysPerMessage && asked.has_next(); ++rows) {
        const std::size_t sample = asked.next();
        const ViewRay ray = film_.ray(sample);
        const Vec3 point = add(ray.origin, picture::scale(ray.direction, depths_[sample]));
        std::copy(point.begin(), point.end(), &buffer.positions[3 * rows]);
      }
      return rows;
    };
    const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
      for (std::size_t row = 0; row < count && answered.has_next(); ++row)
        take(samples_[answered.next()], hits.t[row]);
      progress_(0.5 + 0.5 * part(first + count, report_.hits));
      return Status();
    };
    HitFields fields;
    fields.t = true;
    return count_work(
        client_.nearest_stream(scene_.name, source, {}, fields, sink, options_of_rest()));
  }

  // Paints the samples that miss the node.
  Status paint_behind() {
    if (request_.with_context) return paint_context();
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (samples_[i].light < 0) film_.expose(i, backdrop(film_.height_of(i)));
    }
    return {};
  }

  Clearance finish() {
    const ValueRange range{0, request_.range.value_or(greatest_ > 0 ? greatest_ : 1)};
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (samples_[i].light >= 0) film_.expose(i, clearance_shade(samples_[i], range));
    }
    Clearance clearance{.report = report_, .scale = scale_of(range)};
    if (least_ <= greatest_) clearance.distances = {least_, greatest_};
    return clearance;
  }

 private:
  static double part(std::uint64_t done, std::uint64_t all) {
    return static_cast<double>(done) / static_cast<double>(all);
  }

  double light_of(std::size_t sample, const HitView& hits, std::size_t row) const {
    Vec3 normal{};
    for (std::size_t k = 0; k < 3; ++k) normal[k] = static_cast<double>(hits.normal[3 * row + k]);
    return light_on(facing(normal, film_.ray(sample).direction), film_.camera());
  }

  void see(std::size_t sample, const HitView& hits, std::size_t row) {
    if (hits.hit[row] != 1) return;
    samples_[sample].light = static_cast<float>(light_of(sample, hits, row));
    depths_[sample] = hits.t[row];
  }

  void take(Sample& sample, double distance) {
    sample.value = static_cast<float>(distance);
    if (!std::isfinite(distance)) return;
    least_ = std::min(least_, distance);
    greatest_ = std::max(greatest_, distance);
  }

  Status paint_context() {
    const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
      for (std::size_t row = 0; row < count; ++row) {
        const std::size_t sample = first + row;
        if (samples_[sample].light >= 0) continue;
        film_.expose(sample, hits.hit[row] == 1 ? context_shade(light_of(sample, hits, row))
                                                : backdrop(film_.height_of(sample)));
      }
      return Status();
    };
    HitFields fields;
    fields.hit = fields.normal = true;
    return count_work(cast_view(client_, scene_.name, film_, {0, film_.samples()}, fields, sink,
                                options_of_rest()));
  }

  CastOptions options_of_rest() const {
    return {.exclude = {request_.node}, .consistency = {.exact_revision = report_.revision}};
  }

  Status count_work(const Result<CastReport>& cast) {
    if (!cast) return cast.error();
    report_.cells_expanded += cast->cells_expanded;
    return {};
  }

  Scale scale_of(const ValueRange& range) const {
    Scale scale = depth_scale(range, scene_.meters_per_unit);
    scale.title = "clearance";
    scale.colour = clearance_colour;
    if (report_.hits > 0 && least_ > greatest_) scale.notes = {"grey is", "alone"};
    return scale;
  }

  const Client& client_;
  const SceneInfo& scene_;
  Film& film_;
  const ClearanceRequest& request_;
  const std::function<void(double)>& progress_;
  std::vector<Sample> samples_;  // light below 0: the ray misses the node
  std::vector<double> depths_;   // along the ray of each sample
  double least_ = std::numeric_limits<double>::infinity(), greatest_ = -least_;
  CastReport report_;
};

}  // namespace

Result<Clearance> paint_clearance(const Client& client, const SceneInfo& scene, Film& film,
                                  const ClearanceRequest& request, const Consistency& consistency,
                                  const std::function<void(double)>& progress) {
  ClearancePainter painter(client, scene, film, request, progress);
  if (const Status cast = painter.cast(consistency); !cast) return cast.error();
  if (const Status measured = painter.measure(); !measured) return measured.error();
  if (const Status painted = painter.paint_behind(); !painted) return painted.error();
  return painter.finish();
}

}  // namespace sightline::client::cli::picture
