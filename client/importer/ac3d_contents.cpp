// Reads the lines "loc", "rot", "numsurf" and "kids" of each object.
#include "client/importer/ac3d_contents.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "client/importer/formats/text.h"

namespace sightline::client::importer {
namespace {

struct Object {
  std::uint64_t line = 0;
  std::array<double, 3> offset{};
  std::array<double, 9> axes{1, 0, 0, 0, 1, 0, 0, 0, 1};
  bool has_surfaces = false;
};

template <std::size_t Count>
void read_numbers(std::string_view rest, std::array<double, Count>& numbers) {
  for (double& number : numbers)
    number = formats::number(formats::take_word(rest)).value_or(number);
}

// An AC3D rotation is for rows, and Assimp takes it for columns.
bool is_misplaced(const Object& object, bool has_children) {
  const auto& a = object.axes;
  if (a[1] != a[3] || a[2] != a[6] || a[5] != a[7]) return true;
  const bool is_turned = a != Object{}.axes;
  return object.offset != Object{}.offset && object.has_surfaces && (has_children || is_turned);
}

}  // namespace

void check_ac3d(std::string_view text, FileScene& scene) {
  Object object;
  std::uint64_t count = 0, first = 0;
  formats::TextCursor lines(text);
  while (!lines.is_at_end()) {
    const std::uint64_t line = lines.line();
    std::string_view rest = lines.rest_of_line();
    const std::string_view word = formats::take_word(rest);
    const auto number = [&] { return formats::integer(formats::take_word(rest)).value_or(0); };
    if (word == "OBJECT") {
      object = {.line = line};
    } else if (word == "loc") {
      read_numbers(rest, object.offset);
    } else if (word == "rot") {
      read_numbers(rest, object.axes);
    } else if (word == "numsurf") {
      object.has_surfaces = number() > 0;
    } else if (word == "data") {
      lines.rest_of_line();
    } else if (word == "kids" && is_misplaced(object, number() > 0) && count++ == 0) {
      first = object.line;
    }
  }
  if (count == 0) return;
  scene.warnings.push_back(
      {.kind = "objects_misplaced",
       .count = count,
       .first = fmt::format("line {}", first),
       .message = fmt::format("{} of its objects are turned, which Assimp does the other way, or "
                              "are moved, and it does not move what is below them; the first is in "
                              "line {}",
                              count, first)});
}

}  // namespace sightline::client::importer
