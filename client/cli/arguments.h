// The forms of arguments: numbers, vectors, sizes, names of scenes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sightline::client::cli {

/// The whole text as a decimal number, inf and nan included; a leading + is taken.
std::optional<double> parse_number(std::string_view text);

/// "x,y,z", all finite.
std::optional<std::array<double, 3>> parse_vector(std::string_view text);

struct PictureSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};
inline constexpr std::uint32_t kMaxPictureSide = 8192;
/// "WxH", both from 1 to kMaxPictureSide.
std::optional<PictureSize> parse_size(std::string_view text);

/// SCENE, which is projects/default/scenes/SCENE, or a name in full, in full. Nothing if it is
/// neither.
std::optional<std::string> parse_scene_name(std::string_view text);

}  // namespace sightline::client::cli
