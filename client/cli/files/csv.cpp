// Reads rays line by line.
#include "client/cli/files/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "client/cli/flags.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::size_t kMaxShown = 40;  // characters of a bad value in an error message
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view trim(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// Returns the next value of a line. `line` becomes the rest after its comma, or nothing after the
// last value.
std::string_view next_value(std::optional<std::string_view>& line) {
  const std::size_t comma = line->find(',');
  const std::string_view value = trim(line->substr(0, comma));
  line = comma == std::string_view::npos ? std::nullopt : std::optional(line->substr(comma + 1));
  return value;
}

std::size_t count_values(std::string_view line) {
  return 1 + static_cast<std::size_t>(std::count(line.begin(), line.end(), ','));
}

// Whether the line names columns: it starts with a letter, and its first value is not inf or nan.
bool starts_with_name(std::string_view line) {
  std::optional rest = line;
  const std::string_view first = next_value(rest);
  const char c = first.empty() ? '\0' : first.front();
  const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  return is_letter && !parse_number(first);
}

}  // namespace

Error CsvRays::error(std::string_view what) const {
  return local_error(fmt::format("{}:{}: {}", input_.name(), line_number_, what));
}

// Moves to the next line that is not empty and not a comment.
Result<bool> CsvRays::next_content(std::string_view& line) {
  while (true) {
    auto more = input_.next_line(line);
    if (!more || !*more) return more;
    ++line_number_;
    if (line_number_ == 1 && line.starts_with(kByteOrderMark))
      line.remove_prefix(kByteOrderMark.size());
    line = trim(line);
    if (!line.empty() && line.front() != '#') return true;
  }
}

Status CsvRays::read_names(std::string_view line) {
  for (std::optional rest = line; rest;) {
    const std::string_view name = next_value(rest);
    const auto* const found = std::find(kRayColumns.begin(), kRayColumns.end(), name);
    if (found == kRayColumns.end()) {
      return error(fmt::format("column '{}' is none of {}", name.substr(0, kMaxShown),
                               fmt::join(kRayColumns, " ")));
    }
    const auto column = static_cast<std::size_t>(found - kRayColumns.begin());
    if (std::find(columns_.begin(), columns_.end(), column) != columns_.end()) {
      return error(fmt::format("column '{}' is there twice", name));
    }
    columns_.push_back(column);
  }
  for (std::size_t column = 0; column < 6; ++column) {
    if (std::find(columns_.begin(), columns_.end(), column) == columns_.end()) {
      return error(fmt::format("column '{}' is missing", kRayColumns[column]));
    }
  }
  return {};
}

Status CsvRays::count_columns(std::string_view line) {
  const std::size_t count = count_values(line);
  if (count != 6 && count != 8) {
    return error(
        fmt::format("{} columns, a ray has 6 or 8: {}", count, fmt::join(kRayColumns, " ")));
  }
  columns_.resize(count);
  std::iota(columns_.begin(), columns_.end(), std::size_t{0});
  return {};
}

Result<CsvRays> CsvRays::open(Input input) {
  CsvRays rays(std::move(input));
  std::string_view line;
  const auto more = rays.next_content(line);
  if (!more) return more.error();
  if (!*more) return rays;
  const bool is_named = starts_with_name(line);
  if (const Status known = is_named ? rays.read_names(line) : rays.count_columns(line); !known) {
    return known.error();
  }
  if (!is_named) rays.first_ = line;
  rays.has_interval_ = std::any_of(rays.columns_.begin(), rays.columns_.end(),
                                   [](std::size_t column) { return column >= 6; });
  return rays;
}

Status CsvRays::read_values(std::string_view line, RayRow& row) const {
  row[6] = 0;
  row[7] = std::numeric_limits<double>::infinity();
  const std::size_t count = count_values(line);
  if (count != columns_.size()) {
    return error(fmt::format("{} columns, the lines before have {}", count, columns_.size()));
  }
  std::optional rest = line;
  for (const std::size_t column : columns_) {
    const std::string_view value = next_value(rest);
    const auto number = parse_number(value);
    if (!number) {
      return error(
          fmt::format("{} is '{}', not a number", kRayColumns[column], value.substr(0, kMaxShown)));
    }
    row[column] = *number;
  }
  return {};
}

Result<bool> CsvRays::next(RayRow& row) {
  const std::string first = std::exchange(first_, {});
  std::string_view line = first;
  if (line.empty()) {
    auto more = next_content(line);
    if (!more || !*more) return more;
  }
  if (const Status read = read_values(line, row); !read) return read.error();
  return true;
}

}  // namespace sightline::client::cli::files
