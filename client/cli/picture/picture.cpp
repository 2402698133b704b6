// Casts the rays of the pixels and sums up their colours.
#include "client/cli/picture/picture.h"

#include <fmt/format.h>
#include <png.h>

#include <cassert>
#include <cstddef>
#include <utility>

#include "client/cli/picture/film.h"
#include "client/cli/picture/shading.h"
#include "client/cli/picture/sun.h"
#include "client/cli/picture/view_cast.h"

namespace sightline::client::cli::picture {
namespace {

HitFields fields_of(PictureMode mode) {
  HitFields fields;
  fields.hit = true;
  fields.normal = true;
  fields.t = mode == PictureMode::kDepth;
  fields.node = mode == PictureMode::kNode;
  fields.work = mode == PictureMode::kHeat;
  return fields;
}

// The colours of samples, and the scale that tells what they mean.
struct Shades {
  std::vector<Rgb> colours;
  Scale scale;
};

// Takes one answer per sample. Some modes know the colour at once, others only after all samples.
class Painter {
 public:
  Painter(Film& film, PictureMode mode) : film_(film), mode_(mode) {
    if (is_late()) samples_.resize(film.samples());
  }

  void add(std::size_t sample, const HitView& hits, std::size_t row) {
    const bool is_hit = hits.hit[row] == 1;
    Vec3 normal{};
    if (is_hit) {
      for (std::size_t k = 0; k < 3; ++k) normal[k] = static_cast<double>(hits.normal[3 * row + k]);
      normal = facing(normal, film_.ray(sample).direction);
    }
    if (is_late()) {
      samples_[sample] = late_sample(hits, row, is_hit, normal);
    } else if (!is_hit) {
      film_.expose(sample, backdrop(film_.height_of(sample)));
    } else if (mode_ == PictureMode::kNode) {
      film_.expose(sample, node_shade(hits.node[row], normal, film_.camera()));
    } else {
      film_.expose(sample, normal_shade(normal, film_.camera()));
    }
  }

  // Returns the scale of the colours, if they have one.
  std::optional<Scale> finish(double meters_per_unit) {
    if (!is_late()) return std::nullopt;
    const Shades shades = late_shades(meters_per_unit);
    for (std::size_t i = 0; i < shades.colours.size(); ++i) film_.expose(i, shades.colours[i]);
    return shades.scale;
  }

 private:
  bool is_late() const { return mode_ == PictureMode::kDepth || mode_ == PictureMode::kHeat; }

  Sample late_sample(const HitView& hits, std::size_t row, bool is_hit, const Vec3& normal) const {
    Sample sample;
    sample.light = is_hit ? static_cast<float>(light_on(normal, film_.camera())) : -1.0F;
    if (mode_ == PictureMode::kDepth) {
      sample.value = static_cast<float>(hits.t[row]);
    } else {
      sample.value = static_cast<float>(hits.work[row] & ~kSawDeferred);
      sample.deferred = (hits.work[row] & kSawDeferred) != 0;
    }
    return sample;
  }

  Shades late_shades(double meters_per_unit) const {
    if (mode_ == PictureMode::kDepth) {
      const ValueRange range = depth_range(samples_);
      return {depth_shades(samples_, range), depth_scale(range, meters_per_unit)};
    }
    const ValueRange range = heat_range(samples_);
    return {heat_shades(samples_, range), heat_scale(range)};
  }

  Film& film_;
  PictureMode mode_;
  std::vector<Sample> samples_;
};

double diagonal_of(const SceneInfo& scene) {
  if (!scene.bounds) return 1;
  const auto& b = *scene.bounds;
  return length({b[3] - b[0], b[4] - b[1], b[5] - b[2]});
}

bool has_scale(const PictureRequest& request) {
  switch (request.mode) {
    case PictureMode::kDepth:
    case PictureMode::kHeat:
    case PictureMode::kClearance:
      return request.with_scale;
    default:
      return false;
  }
}

// The size of the view, without the scale.
PictureSize view_size(const PictureRequest& request) {
  PictureSize size = request.size;
  if (has_scale(request)) size.width -= scale_width(size);
  return size;
}

// Puts the scale where view_size() left room for it.
Picture with_scale(Picture picture, const PictureRequest& request) {
  if (has_scale(request) && scale_width(request.size) > 0)
    picture.rgb = beside_scale(picture.rgb, request.size, *picture.scale);
  return picture;
}

Result<Picture> render_clearance(const Client& client, const SceneInfo& scene,
                                 const PictureRequest& request, Film& film,
                                 const std::function<void(double)>& progress) {
  auto painted =
      paint_clearance(client, scene, film, request.clearance, request.consistency, progress);
  if (!painted) return painted.error();
  return with_scale(
      {film.develop(), std::move(painted->report), std::move(painted->scale), painted->distances},
      request);
}

}  // namespace

bool has_view(const PictureRequest& request, const SceneInfo& scene) {
  return make_camera(request.camera, scene, view_size(request)).has_value();
}

Result<Picture> render_picture(const Client& client, const SceneInfo& scene,
                               const PictureRequest& request,
                               const std::function<void(double)>& progress) {
  const PictureSize size = view_size(request);
  Film film(size, make_camera(request.camera, scene, size).value());
  if (request.mode == PictureMode::kLit) {
    auto report =
        paint_in_sun(client, scene.name, film, {diagonal_of(scene), request.consistency}, progress);
    if (!report) return report.error();
    return Picture{film.develop(), *std::move(report)};
  }
  if (request.mode == PictureMode::kClearance)
    return render_clearance(client, scene, request, film, progress);
  Painter painter(film, request.mode);
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
    for (std::size_t i = 0; i < count; ++i) painter.add(first + i, hits, i);
    progress(static_cast<double>(first + count) / static_cast<double>(film.samples()));
    return Status();
  };
  CastOptions options{.consistency = request.consistency};
  if (request.mode == PictureMode::kHeat) options.build = BuildMode::kBuiltOnly;
  auto report = cast_view(client, scene.name, film, {0, film.samples()}, fields_of(request.mode),
                          sink, options);
  if (!report) return report.error();
  auto scale = painter.finish(scene.meters_per_unit);
  return with_scale({film.develop(), *std::move(report), std::move(scale)}, request);
}

Result<std::string> encode_png(std::span<const std::uint8_t> rgb, std::uint32_t width,
                               std::uint32_t height) {
  assert(rgb.size() == std::size_t{3} * width * height);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = PNG_FORMAT_RGB;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(image), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0) {
    return Error{Code::kInternal, fmt::format("PNG: {}", image.message), {}};
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace sightline::client::cli::picture
