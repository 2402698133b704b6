// Pictures as PNG.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "client/result.h"

namespace sightline::client::cli::picture {

/// `rgb`: sRGB, 8 bits, (height, width, 3). Errors: kInternal, in libpng's words.
Result<std::string> encode_png(std::span<const std::uint8_t> rgb, std::uint32_t width,
                               std::uint32_t height);

}  // namespace sightline::client::cli::picture
