// Reads a line at a time; every key must be known.
#include "client/cli/files/json_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "client/cli/flags.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

using nlohmann::json;

bool has_no_value(std::string_view line) {
  return line.find_first_not_of(" \t\r") == std::string_view::npos;
}

bool read_number(const json& value, double& out) {
  if (value.is_number()) {
    out = value.get<double>();
    return true;
  }
  const auto number = value.is_string() ? parse_number(value.get_ref<const std::string&>())
                                        : std::optional<double>();
  if (number) out = *number;
  return number.has_value();
}

Status read_numbers(const json& values, std::string_view name, std::size_t first, std::size_t count,
                    RayRow& row) {
  if (!values.is_array() || values.size() != count)
    return local_error(fmt::format("{} is not {} numbers", name, count));
  for (std::size_t k = 0; k < count; ++k) {
    if (!read_number(values[k], row[first + k]))
      return local_error(fmt::format("{} holds {}, which is no number", name, values[k].dump()));
  }
  return {};
}

// Reads one key, and marks the columns that it has.
Status read_key(const std::string& key, const json& value, RayRow& row,
                std::array<bool, 8>& found) {
  if (key == "origin" || key == "direction") {
    const std::size_t first = key == "origin" ? 0 : 3;
    std::fill_n(found.begin() + static_cast<std::ptrdiff_t>(first), 3, true);
    return read_numbers(value, key, first, 3, row);
  }
  const auto* const column = std::find(kRayColumns.begin(), kRayColumns.end(), key);
  if (column == kRayColumns.end()) {
    return local_error(
        fmt::format("key '{}' is none of origin direction {}", key, fmt::join(kRayColumns, " ")));
  }
  const auto k = static_cast<std::size_t>(column - kRayColumns.begin());
  found[k] = true;
  if (read_number(value, row[k])) return {};
  return local_error(fmt::format("{} is {}, not a number", key, value.dump()));
}

}  // namespace

Status parse_ray(std::string_view line, RayRow& row) {
  row[6] = 0;
  row[7] = std::numeric_limits<double>::infinity();
  const json ray = json::parse(line, nullptr, false);
  if (ray.is_array()) {
    if (ray.size() != 6 && ray.size() != 8)
      return local_error(fmt::format("a list of {}, a ray has 6 or 8 numbers", ray.size()));
    return read_numbers(ray, "the list", 0, ray.size(), row);
  }
  if (!ray.is_object()) return local_error("neither a list nor an object in JSON");
  std::array<bool, 8> found{};
  for (const auto& [key, value] : ray.items()) {
    if (Status good = read_key(key, value, row, found); !good) return good;
  }
  for (std::size_t k = 0; k < 6; ++k) {
    if (!found[k]) return local_error(fmt::format("'{}' is missing", kRayColumns[k]));
  }
  return {};
}

Result<bool> JsonRays::next(RayRow& row) {
  while (true) {
    std::string_view line;
    auto more = input_.next_line(line);
    if (!more || !*more) return more;
    ++line_number_;
    if (has_no_value(line)) continue;
    const Status parsed = parse_ray(line, row);
    if (parsed) return true;
    return local_error(
        fmt::format("{}:{}: {}", input_.name(), line_number_, parsed.error().message));
  }
}

Result<bool> JsonRays::ready() {
  while (true) {
    const auto line = input_.ready_line();
    if (!line) return line.error();
    if (!*line) return false;
    if ((*line)->at_end || !has_no_value((*line)->line)) return true;
    std::string_view passed_over;
    auto more = input_.next_line(passed_over);
    if (!more) return more;
    ++line_number_;
  }
}

Result<bool> JsonRays::wait(std::chrono::milliseconds longest) {
  return wait_for_line(input_, *this, longest);
}

}  // namespace sightline::client::cli::files
