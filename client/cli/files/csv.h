// Rays in CSV, one per line: ox oy oz dx dy dz [tmin tmax]. A line of names may come first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "client/cli/files/input.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// The columns of a ray, in the order of a file without a line of names.
inline constexpr std::array<std::string_view, 8> kRayColumns{"ox", "oy", "oz",   "dx",
                                                             "dy", "dz", "tmin", "tmax"};
using RayRow = std::array<double, kRayColumns.size()>;

/// Values are separated by commas. Blanks around values, empty lines and lines that start with #
/// are ignored. With a line of names, columns may come in any order, and tmin and tmax may each be
/// left out. Errors: kInvalidArgument, with the file's name, the line and what is wrong there.
class CsvRays {
 public:
  /// Opens the file and reads up to the first ray.
  static Result<CsvRays> open(Input input);

  /// Whether the file has a column tmin or tmax.
  bool has_interval() const { return has_interval_; }

  /// Reads the next ray. Returns false at the end. Bounds that the file does not have are 0 and
  /// infinity.
  Result<bool> next(RayRow& row);

 private:
  explicit CsvRays(Input input) : input_(std::move(input)) {}
  Result<bool> next_content(std::string_view& line);
  Status read_names(std::string_view line);
  Status count_columns(std::string_view line);
  Status read_values(std::string_view line, RayRow& row) const;
  Error error(std::string_view what) const;

  Input input_;
  std::uint64_t line_number_ = 0;
  std::string first_;                 // the line of the first ray, until it is read
  std::vector<std::size_t> columns_;  // for each value of a line, its index in kRayColumns
  bool has_interval_ = false;
};

}  // namespace sightline::client::cli::files
