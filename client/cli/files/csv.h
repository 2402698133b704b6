// Rays in CSV, one per line: ox oy oz dx dy dz [tmin tmax]; or points: x y z [max]. A line of names
// may come first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "client/cli/files/input.h"
#include "client/cli/files/row_reader.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// Values are separated by commas, or by blanks in a line without commas. Blanks around values,
/// empty lines and lines that start with # are ignored. With a line of names, columns may come in
/// any order, and tmin, tmax and max may each be left out. Errors: kInvalidArgument, with the
/// file's name, the line and what is wrong there.
class CsvRays : public RowReader {
 public:
  /// Opens the file and reads up to the first ray.
  static Result<CsvRays> open(Input input, RowKind kind = RowKind::kRays);

  /// Whether the file has a column that may be left out.
  bool has_interval() const { return has_interval_; }

  /// Reads the next ray. Returns false at the end. Bounds that the file does not have are 0 and
  /// infinity.
  Result<bool> next(RayRow& row) override;
  Result<bool> ready() override;
  Result<bool> wait(std::chrono::milliseconds longest) override;

 private:
  CsvRays(Input input, RowKind kind) : input_(std::move(input)), layout_(layout_of(kind)) {}
  Result<bool> next_content(std::string_view& line);
  Status read_names(std::string_view line);
  Status count_columns(std::string_view line);
  Status read_values(std::string_view line, RayRow& row);
  Error error(std::string_view what) const;

  Input input_;
  std::reference_wrapper<const RowLayout> layout_;
  std::uint64_t line_number_ = 0;
  std::string first_;                     // the line of the first ray, until it is read
  std::vector<std::size_t> columns_;      // for each value of a line, its index among the names
  std::vector<std::string_view> values_;  // values of the line that is being read
  bool has_interval_ = false;
};

}  // namespace sightline::client::cli::files
