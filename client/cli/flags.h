// The forms of arguments: numbers, vectors, sizes, names of scenes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "client/types.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

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

/// Makes it a usage error to name none of the verbs under `app`, or one that is none.
void require_verb(CLI::App& app);

/// Adds the positional SCENE; `name` gets the full resource name.
void add_scene_argument(CLI::App& verb, std::string& name);

/// For an option that takes a number above 0.
CLI::Validator positive_number();

/// `consistency` gets what they say, and must live until the program has been parsed.
void add_consistency_flags(CLI::App& verb, Consistency& consistency);

}  // namespace sightline::client::cli
