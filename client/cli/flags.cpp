// Parses single arguments, and adds flags that verbs share.
#include "client/cli/flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "client/cli/terminal.h"

namespace sightline::client::cli {
namespace {

constexpr std::size_t kMaxIdBytes = 63;

std::optional<std::uint32_t> parse_side(std::string_view text) {
  std::uint32_t side = 0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), side);
  if (error != std::errc() || end != text.end() || side < 1 || side > kMaxPictureSide) return {};
  return side;
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double x = 0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), x);
  // A number beyond the range of a double is refused. strtod would return infinity or zero.
  if (error != std::errc() || end != text.end()) return {};
  return x;
}

std::optional<std::array<double, 3>> parse_vector(std::string_view text) {
  std::array<double, 3> v{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != (k == 2)) return {};
    const auto x = parse_number(text.substr(0, comma));
    if (!x || !std::isfinite(*x)) return {};
    v[k] = *x;
    if (k < 2) text.remove_prefix(comma + 1);
  }
  return v;
}

Result<Transform> to_transform(std::span<const double> numbers) {
  if (numbers.size() != 12 && numbers.size() != 16)
    return local_error(fmt::format("a matrix has 12 or 16 numbers, not {}", numbers.size()));
  for (const double x : numbers) {
    if (!std::isfinite(x)) return local_error("a matrix has finite numbers");
  }
  Transform out{};
  std::copy_n(numbers.begin(), out.size(), out.begin());
  if (numbers.size() == 12) return out;
  constexpr std::array<double, 4> kLast{0, 0, 0, 1};
  if (std::equal(kLast.begin(), kLast.end(), numbers.begin() + 12)) return out;
  const bool is_turned = numbers[3] == 0 && numbers[7] == 0 && numbers[11] == 0 && numbers[15] == 1;
  return local_error(is_turned ? "the matrix is column by column; give it row by row"
                               : "the last row of a matrix of 16 is 0 0 0 1");
}

std::optional<PictureSize> parse_size(std::string_view text) {
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos) return {};
  const auto width = parse_side(text.substr(0, cross));
  const auto height = parse_side(text.substr(cross + 1));
  if (!width || !height) return {};
  return PictureSize{*width, *height};
}

bool is_id(std::string_view text) {
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  if (text.empty() || text.size() > kMaxIdBytes || !is_plain(text.front())) return false;
  for (const char c : text) {
    if (!is_plain(c) && c != '.' && c != '_' && c != '-') return false;
  }
  return true;
}

std::optional<std::string> parse_scene_name(std::string_view text) {
  if (is_id(text)) return "projects/default/scenes/" + std::string(text);
  std::string_view rest = text;
  if (!rest.starts_with("projects/")) return {};
  rest.remove_prefix(9);
  const std::size_t middle = rest.find("/scenes/");
  if (middle == std::string_view::npos) return {};
  if (!is_id(rest.substr(0, middle)) || !is_id(rest.substr(middle + 8))) return {};
  return std::string(text);
}

const std::map<std::string, QueryKind> kQueryKinds{{"closest", QueryKind::kClosest},
                                                   {"any", QueryKind::kAny},
                                                   {"all", QueryKind::kAll},
                                                   {"count", QueryKind::kCount}};

void require_verb(CLI::App& app) {
  // App::require_subcommand alone reports its error first and does not name the unknown word.
  app.require_subcommand(0, 1);
  app.callback([&app] {
    if (app.get_subcommands().empty()) throw CLI::RequiredError("A verb");
  });
}

Error unreadable_file(Error error, const std::string& scene) {
  const std::string name = scene.substr(scene.rfind('/') + 1);
  std::error_code ignored;
  if (std::filesystem::is_regular_file(name, ignored))
    error.message += fmt::format("; {} is a file: SCENE comes before FILE", name);
  return error;
}

namespace {

/// Makes a full name of a short one.
CLI::Validator scene_name() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        const auto full = parse_scene_name(text);
        if (!full) {
          std::error_code ignored;
          const bool is_file = std::filesystem::is_regular_file(text, ignored);
          return "'" + text +
                 (is_file ? "' is a file: SCENE comes before it"
                          : "' is no scene name: 1 to 63 of a-z 0-9 . _ -, the first a letter or "
                            "digit");
        }
        text = *full;
        return {};
      },
      "");
}

}  // namespace

void add_scene_argument(CLI::App& verb, std::string& name) {
  verb.add_option("SCENE", name, "The scene: a name, or projects/PROJECT/scenes/NAME")
      ->required()
      ->transform(scene_name());
}

void add_scene_option(CLI::App& verb, std::string& name) {
  verb.add_option("--scene", name, "Only this one: a name, or projects/PROJECT/scenes/NAME")
      ->transform(scene_name())
      ->type_name("SCENE");
}

CLI::Validator positive_number() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        const auto number = parse_number(text);
        return number && *number > 0 && std::isfinite(*number)
                   ? ""
                   : "'" + text + "' is not a number above 0";
      },
      "");
}

void add_consistency_flags(CLI::App& verb, Consistency& consistency) {
  CLI::Option* const at_least =
      verb.add_option(
              "--at-least", consistency.at_least,
              "Wait until the scene is at the revision of this token, which update, stream, "
              "watch and cast print")
          ->type_name("TOKEN");
  verb.add_option("--revision", consistency.exact_revision,
                  "As the scene was at this revision, if it is still kept (default: the latest)")
      ->excludes(at_least)
      ->type_name("N");
}

}  // namespace sightline::client::cli
