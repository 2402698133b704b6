// libpng's simplified interface: no longjmp to mind.
#include "client/cli/picture/png.h"

#include <fmt/format.h>
#include <png.h>

#include <cassert>

namespace sightline::client::cli::picture {

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
