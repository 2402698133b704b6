// Reads rows line by line.
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

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// The values of a line that is trimmed and not empty.
void split(std::string_view line, std::vector<std::string_view>& values) {
  values.clear();
  const bool by_commas = line.find(',') != std::string_view::npos;
  for (std::optional rest = line; rest;) {
    const std::size_t end = by_commas ? rest->find(',') : rest->find_first_of(" \t");
    values.push_back(trim(rest->substr(0, end)));
    if (end == std::string_view::npos) return;
    rest = by_commas ? rest->substr(end + 1) : trim(rest->substr(end));
  }
}

bool is_content(std::string_view line) { return !line.empty() && line.front() != '#'; }

// Whether the line names columns: it starts with a letter, and its first value is not inf or nan.
bool starts_with_name(std::string_view first) {
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
    if (is_content(line)) return true;
  }
}

Status CsvRays::read_names(std::string_view line) {
  const auto names = layout_.get().names;
  split(line, values_);
  for (const std::string_view name : values_) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      return error(fmt::format("column '{}' is none of {}", name.substr(0, kMaxShown),
                               fmt::join(names, " ")));
    }
    const auto column = static_cast<std::size_t>(found - names.begin());
    if (std::find(columns_.begin(), columns_.end(), column) != columns_.end()) {
      return error(fmt::format("column '{}' is there twice", name));
    }
    columns_.push_back(column);
  }
  for (std::size_t column = 0; column < layout_.get().required; ++column) {
    if (std::find(columns_.begin(), columns_.end(), column) == columns_.end()) {
      return error(fmt::format("column '{}' is missing", names[column]));
    }
  }
  return {};
}

Status CsvRays::count_columns(std::string_view line) {
  split(line, values_);
  const RowLayout& layout = layout_;
  const std::size_t count = values_.size();
  if (count != layout.required && count != layout.names.size()) {
    return error(fmt::format("{} column{}, a {} has {} or {}: {}", count, count == 1 ? "" : "s",
                             layout.row, layout.required, layout.names.size(),
                             fmt::join(layout.names, " ")));
  }
  columns_.resize(count);
  std::iota(columns_.begin(), columns_.end(), std::size_t{0});
  return {};
}

Result<CsvRays> CsvRays::open(Input input, RowKind kind) {
  CsvRays rays(std::move(input), kind);
  std::string_view line;
  const auto more = rays.next_content(line);
  if (!more) return more.error();
  if (!*more) return rays;
  split(line, rays.values_);
  const bool is_named = starts_with_name(rays.values_.front());
  if (const Status known = is_named ? rays.read_names(line) : rays.count_columns(line); !known) {
    return known.error();
  }
  if (!is_named) rays.first_ = line;
  rays.has_interval_ =
      std::any_of(rays.columns_.begin(), rays.columns_.end(),
                  [&rays](std::size_t column) { return column >= rays.layout_.get().required; });
  return rays;
}

Status CsvRays::read_values(std::string_view line, RayRow& row) {
  const RowLayout& layout = layout_;
  row[6] = 0;
  row[7] = std::numeric_limits<double>::infinity();
  split(line, values_);
  if (values_.size() != columns_.size()) {
    return error(
        fmt::format("{} columns, the lines before have {}", values_.size(), columns_.size()));
  }
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const std::size_t column = columns_[k];
    const std::string_view value = values_[k];
    const auto number = parse_number(value);
    if (!number) {
      return error(fmt::format("{} is '{}', not a number", layout.names[column],
                               value.substr(0, kMaxShown)));
    }
    row[layout.columns[column]] = *number;
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

Result<bool> CsvRays::ready() {
  if (!first_.empty()) return true;
  while (true) {
    const auto line = input_.ready_line();
    if (!line) return line.error();
    if (!*line) return false;
    if ((*line)->at_end || is_content(trim((*line)->line))) return true;
    std::string_view passed_over;
    auto more = input_.next_line(passed_over);
    if (!more) return more;
    ++line_number_;
  }
}

Result<bool> CsvRays::wait(std::chrono::milliseconds longest) {
  return wait_for_line(input_, *this, longest);
}

}  // namespace sightline::client::cli::files
