// Parsers of arguments (numbers, vectors, sizes, names of scenes), and flags that verbs share.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "client/cast_options.h"
#include "client/result.h"
#include "client/types.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace sightline::client::cli {

/// Parses the whole text as a decimal number. inf, nan and a leading + are allowed.
std::optional<double> parse_number(std::string_view text);

/// Parses "x,y,z", all finite.
std::optional<std::array<double, 3>> parse_vector(std::string_view text);

/// An affine map of 12 numbers (rows of [linear | translation]) or of 16, whose last row is 0 0
/// 0 1. Errors: kInvalidArgument, saying what is wrong.
Result<Transform> to_transform(std::span<const double> numbers);

struct PictureSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};
inline constexpr std::uint32_t kMaxPictureSide = 8192;
/// Parses "WxH", both from 1 to kMaxPictureSide.
std::optional<PictureSize> parse_size(std::string_view text);

/// Returns the full name of a scene. A short name SCENE means projects/default/scenes/SCENE; a full
/// name is returned as it is. Returns nothing for any other text.
std::optional<std::string> parse_scene_name(std::string_view text);

/// Whether the text names a project or a scene: 1 to 63 of a-z 0-9 . _ -, the first a letter or
/// digit.
bool is_id(std::string_view text);

/// The values of --kind.
extern const std::map<std::string, QueryKind> kQueryKinds;

/// Makes it a usage error if `app` is called without a verb, or with an unknown one.
void require_verb(CLI::App& app);

/// The error of a FILE that cannot be read; it says so if SCENE is the name of a file instead.
Error unreadable_file(Error error, const std::string& scene);

/// Adds the positional argument SCENE. `name` receives the full resource name.
void add_scene_argument(CLI::App& verb, std::string& name);

/// Adds --scene. `name` receives the full resource name, or stays as it is.
void add_scene_option(CLI::App& verb, std::string& name);

/// A check for options that take a number above 0.
CLI::Validator positive_number();

/// Adds --at-least and --revision. `consistency` receives their values, and must live until the
/// program has been parsed.
void add_consistency_flags(CLI::App& verb, Consistency& consistency);

}  // namespace sightline::client::cli
