// Casts the rays of the pixels and sums up their colours.
#include "client/cli/picture/picture.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>

#include "client/cli/picture/shading.h"

namespace sightline::client::cli::picture {
namespace {

// The pixels of a picture and their sums of colours. Sample s of the k-th pixel in tile order has
// the number k * kSamplesPerPixel + s.
class Film {
 public:
  Film(PictureSize size, const Camera& camera)
      : size_(size), camera_(camera), pixels_(tiled_pixels(size)), sums_(pixels_.size(), Rgb{}) {}

  std::size_t samples() const { return pixels_.size() * kSamplesPerPixel; }

  // 0 at the top of the picture, 1 at the bottom.
  double height_of(std::size_t sample) const {
    const auto [x, y] = pixels_[sample / kSamplesPerPixel];
    return (y + kSampleOffsets[sample % kSamplesPerPixel][1]) / size_.height;
  }

  Vec3 direction(std::size_t sample) const {
    const auto [x, y] = pixels_[sample / kSamplesPerPixel];
    const double across = (x + kSampleOffsets[sample % kSamplesPerPixel][0]) / size_.height;
    const double aspect = static_cast<double>(size_.width) / size_.height;
    return camera_.direction(across, height_of(sample), aspect);
  }

  void expose(std::size_t sample, const Rgb& colour) {
    Rgb& sum = sums_[sample / kSamplesPerPixel];
    for (std::size_t c = 0; c < 3; ++c) sum[c] += colour[c] / float{kSamplesPerPixel};
  }

  std::vector<std::uint8_t> develop() const {
    std::vector<std::uint8_t> rgb(3 * pixels_.size());
    for (std::size_t k = 0; k < pixels_.size(); ++k) {
      const std::size_t index = std::size_t{pixels_[k].y} * size_.width + pixels_[k].x;
      for (std::size_t c = 0; c < 3; ++c) rgb[3 * index + c] = encode_srgb(sums_[k][c]);
    }
    return rgb;
  }

 private:
  PictureSize size_;
  Camera camera_;
  std::vector<Pixel> pixels_;
  std::vector<Rgb> sums_;
};

HitFields fields_of(PictureMode mode) {
  HitFields fields;
  fields.hit = true;
  fields.normal = true;
  fields.t = mode == PictureMode::kDepth;
  fields.node = mode == PictureMode::kNode;
  fields.work = mode == PictureMode::kHeat;
  return fields;
}

// Takes one answer per sample. Some modes know the colour at once, others only after all samples.
class Painter {
 public:
  Painter(Film& film, const PictureRequest& request) : film_(film), request_(request) {
    if (is_late()) samples_.resize(film.samples());
  }

  void add(std::size_t sample, const HitView& hits, std::size_t row) {
    const bool is_hit = hits.hit[row] == 1;
    Vec3 normal{};
    if (is_hit) {
      for (std::size_t k = 0; k < 3; ++k) normal[k] = static_cast<double>(hits.normal[3 * row + k]);
      normal = facing(normal, film_.direction(sample));
    }
    if (is_late()) {
      samples_[sample] = late_sample(hits, row, is_hit, normal);
    } else if (!is_hit) {
      film_.expose(sample, backdrop(film_.height_of(sample)));
    } else if (request_.mode == PictureMode::kNode) {
      film_.expose(sample, node_shade(hits.node[row], normal, request_.camera));
    } else {
      film_.expose(sample, normal_shade(normal, request_.camera, request_.up_axis));
    }
  }

  void finish() {
    if (!is_late()) return;
    const std::vector<Rgb> colours =
        request_.mode == PictureMode::kDepth ? depth_shades(samples_) : heat_shades(samples_);
    for (std::size_t i = 0; i < colours.size(); ++i) film_.expose(i, colours[i]);
  }

 private:
  bool is_late() const {
    return request_.mode == PictureMode::kDepth || request_.mode == PictureMode::kHeat;
  }

  Sample late_sample(const HitView& hits, std::size_t row, bool is_hit, const Vec3& normal) const {
    Sample sample;
    sample.light = is_hit ? static_cast<float>(light_on(normal, request_.camera)) : -1.0F;
    if (request_.mode == PictureMode::kDepth) {
      sample.value = static_cast<float>(hits.t[row]);
    } else {
      sample.value = static_cast<float>(hits.work[row] & ~kSawDeferred);
      sample.deferred = (hits.work[row] & kSawDeferred) != 0;
    }
    return sample;
  }

  Film& film_;
  const PictureRequest& request_;
  std::vector<Sample> samples_;
};

}  // namespace

Result<Picture> render_picture(const Client& client, const std::string& scene,
                               const PictureRequest& request,
                               const std::function<void(double)>& progress) {
  Film film(request.size, request.camera);
  Painter painter(film, request);
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) {
    for (std::size_t i = 0; i < count; ++i) painter.add(first + i, hits, i);
    progress(static_cast<double>(first + count) / static_cast<double>(film.samples()));
    return Status();
  };
  CastOptions options{.consistency = request.consistency};
  if (request.mode == PictureMode::kHeat) options.build = BuildMode::kBuiltOnly;
  auto report = client.cast_stream(scene, rays_of(request.camera, request.size),
                                   fields_of(request.mode), sink, options);
  if (!report) return report.error();
  painter.finish();
  return Picture{film.develop(), *report};
}

std::vector<Pixel> tiled_pixels(PictureSize size) {
  constexpr std::uint32_t kTile = 8;
  std::vector<Pixel> pixels;
  pixels.reserve(std::size_t{size.width} * size.height);
  for (std::uint32_t top = 0; top < size.height; top += kTile) {
    for (std::uint32_t left = 0; left < size.width; left += kTile) {
      for (std::uint32_t y = top; y < std::min(top + kTile, size.height); ++y) {
        for (std::uint32_t x = left; x < std::min(left + kTile, size.width); ++x) {
          pixels.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
        }
      }
    }
  }
  return pixels;
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
