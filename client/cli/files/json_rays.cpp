// Reads a line at a time; every key must be known.
#include "client/cli/files/json_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <tuple>
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

/// Numbers of a row by their names, and which of them have been read.
class NamedNumbers {
 public:
  NamedNumbers(const RowLayout& layout, RayRow& row) : layout_(layout), row_(row) {}

  Status read_list(const json& values, std::string_view name, std::size_t first,
                   std::size_t count) {
    if (!values.is_array() || values.size() != count)
      return local_error(fmt::format("{} is not {} numbers", name, count));
    for (std::size_t k = 0; k < count; ++k) {
      if (!read(values[k], first + k))
        return local_error(fmt::format("{} holds {}, which is no number", name, values[k].dump()));
    }
    return {};
  }

  Status read_key(const std::string& key, const json& value) {
    for (const auto& [name, first] : layout_.vectors) {
      if (key == name) return read_list(value, key, first, 3);
    }
    const auto found = std::find(layout_.names.begin(), layout_.names.end(), key);
    if (found == layout_.names.end())
      return local_error(fmt::format("key '{}' is none of {}", key, known_keys()));
    if (read(value, static_cast<std::size_t>(found - layout_.names.begin()))) return {};
    return local_error(fmt::format("{} is {}, not a number", key, value.dump()));
  }

  Status check_complete() const {
    for (std::size_t k = 0; k < layout_.required; ++k) {
      if (!found_[k]) return local_error(fmt::format("'{}' is missing", layout_.names[k]));
    }
    return {};
  }

 private:
  bool read(const json& value, std::size_t name) {
    found_[name] = true;
    return read_number(value, row_[layout_.columns[name]]);
  }

  std::string known_keys() const {
    std::string keys;
    for (const auto& [name, first] : layout_.vectors) keys += fmt::format("{} ", name);
    return keys + fmt::format("{}", fmt::join(layout_.names, " "));
  }

  const RowLayout& layout_;
  RayRow& row_;
  std::array<bool, std::tuple_size_v<RayRow>> found_{};
};

}  // namespace

Status parse_json_row(std::string_view line, RayRow& row, RowKind kind) {
  const RowLayout& layout = layout_of(kind);
  row[6] = 0;
  row[7] = std::numeric_limits<double>::infinity();
  NamedNumbers numbers(layout, row);
  const json parsed = json::parse(line, nullptr, false);
  if (parsed.is_array()) {
    const std::size_t count = parsed.size();
    if (count != layout.required && count != layout.names.size()) {
      return local_error(fmt::format("a list of {}, a {} has {} or {} numbers", count, layout.row,
                                     layout.required, layout.names.size()));
    }
    return numbers.read_list(parsed, "the list", 0, count);
  }
  if (!parsed.is_object()) return local_error("neither a list nor an object in JSON");
  for (const auto& [key, value] : parsed.items()) {
    if (Status good = numbers.read_key(key, value); !good) return good;
  }
  return numbers.check_complete();
}

Result<bool> JsonRays::next(RayRow& row) {
  while (true) {
    std::string_view line;
    auto more = input_.next_line(line);
    if (!more || !*more) return more;
    ++line_number_;
    if (has_no_value(line)) continue;
    const Status parsed = parse_json_row(line, row, kind_);
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
