// Paints some samples at a time, so that large pictures need little memory.
#include "client/cli/picture/sun.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "client/cli/picture/view_cast.h"

namespace sightline::client::cli::picture {
namespace {

constexpr std::uint64_t kSamplesAtATime = std::uint64_t{1} << 18U;
constexpr double kSunRadius = 0.02;      // at distance 1: shadows have soft edges
constexpr double kAboveSurface = 1e-5;   // where rays to the sun start, in sizes of the scene
constexpr double kNearlyUpright = 1e-3;  // the sine of the angle between view and up axis

struct Surface {
  std::size_t sample = 0;
  Vec3 point{};
  Vec3 normal{};  // faces the camera
  bool in_shadow = false;
};

class SunPainter {
 public:
  SunPainter(const Client& client, const std::string& scene, Film& film, const SunRequest& request)
      : client_(client),
        scene_(scene),
        film_(film),
        request_(request),
        axes_(upright_axes(direction_to_sun(film.camera()))) {}

  Status paint(SampleRange samples) {
    surfaces_.clear();
    if (Status seen = find_surfaces(samples); !seen) return seen;
    if (Status lit = find_shadows(); !lit) return lit;
    for (const Surface& surface : surfaces_) {
      film_.expose(surface.sample,
                   sun_shade(surface.normal, axes_.up, surface.in_shadow, film_.camera()));
    }
    return {};
  }

  CastReport report() const { return report_; }

 private:
  Status find_surfaces(SampleRange samples) {
    HitFields fields;
    fields.t = fields.hit = fields.normal = true;
    const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
      for (std::size_t row = 0; row < count; ++row) see(samples.first + first + row, hits, row);
      return Status();
    };
    return add(cast_view(client_, scene_, film_, samples, fields, sink,
                         {.consistency = request_.consistency}));
  }

  void see(std::size_t sample, const HitView& hits, std::size_t row) {
    if (hits.hit[row] != 1) return film_.expose(sample, backdrop(film_.height_of(sample)));
    const ViewRay ray = film_.ray(sample);
    Surface surface{.sample = sample,
                    .point = picture::add(ray.origin, scale(ray.direction, hits.t[row]))};
    for (std::size_t k = 0; k < 3; ++k)
      surface.normal[k] = static_cast<double>(hits.normal[3 * row + k]);
    surface.normal = facing(surface.normal, ray.direction);
    surface.in_shadow = dot(surface.normal, axes_.up) <= 0;
    surfaces_.push_back(surface);
  }

  // A part of the sun's disc for each sample of a pixel.
  Vec3 to_sun(std::size_t sample) const {
    const auto [x, y] = kSampleOffsets[sample % kSamplesPerPixel];
    const Vec3 aside = picture::add(scale(axes_.side, 2 * x - 1), scale(axes_.front, 2 * y - 1));
    return picture::add(axes_.up, scale(aside, kSunRadius));
  }

  Status find_shadows() {
    std::vector<std::size_t> asked;
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
      if (!surfaces_[i].in_shadow) asked.push_back(i);
    }
    if (asked.empty()) return {};
    std::size_t next = 0;
    const RaySource<double> source = [&](const RayColumns<double>& buffer) -> Result<std::size_t> {
      const std::size_t rows = std::min(kRaysPerMessage, asked.size() - next);
      for (std::size_t row = 0; row < rows; ++row, ++next) {
        const Surface& surface = surfaces_[asked[next]];
        const Vec3 start =
            picture::add(surface.point, scale(surface.normal, kAboveSurface * request_.scene_size));
        const Vec3 direction = to_sun(surface.sample);
        std::copy(start.begin(), start.end(), &buffer.origins[3 * row]);
        std::copy(direction.begin(), direction.end(), &buffer.directions[3 * row]);
      }
      return rows;
    };
    const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
      for (std::size_t row = 0; row < count; ++row)
        surfaces_[asked[first + row]].in_shadow = hits.hit[row] == 1;
      return Status();
    };
    HitFields fields;
    fields.hit = true;
    return add(client_.cast_stream(scene_, source, RayShape{}, fields, sink,
                                   {.kind = QueryKind::kAny, .consistency = request_.consistency}));
  }

  Status add(const Result<CastReport>& cast) {
    if (!cast) return cast.error();
    report_.revision = cast->revision;
    report_.token = cast->token;
    report_.rays += cast->rays;
    report_.hits += cast->hits;
    report_.cells_expanded += cast->cells_expanded;
    return {};
  }

  const Client& client_;
  const std::string& scene_;
  Film& film_;
  const SunRequest& request_;
  const Axes axes_;  // up: to the sun
  std::vector<Surface> surfaces_;
  CastReport report_;
};

}  // namespace

Vec3 direction_to_sun(const Camera& camera) {
  const Vec3& up = camera.scene.up;
  Vec3 ahead = sub(camera.forward, scale(up, dot(camera.forward, up)));
  if (length(ahead) < kNearlyUpright) ahead = camera.up;
  ahead = unit(ahead);
  const Vec3 right = cross(ahead, up);
  return unit(add(up, add(scale(ahead, -0.45), scale(right, -0.7))));
}

Result<CastReport> paint_in_sun(const Client& client, const std::string& scene, Film& film,
                                const SunRequest& request,
                                const std::function<void(double)>& progress) {
  SunPainter painter(client, scene, film, request);
  for (std::uint64_t first = 0; first < film.samples(); first += kSamplesAtATime) {
    const std::uint64_t count = std::min<std::uint64_t>(kSamplesAtATime, film.samples() - first);
    if (const Status painted = painter.paint({first, count}); !painted) return painted.error();
    progress(static_cast<double>(first + count) / static_cast<double>(film.samples()));
  }
  return painter.report();
}

}  // namespace sightline::client::cli::picture
