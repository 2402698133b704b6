// Rays or points as JSON, one per line.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "client/cli/files/input.h"
#include "client/cli/files/row_reader.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// A line is [ox, oy, oz, dx, dy, dz], the same with tmin and tmax, {"origin": [3], "direction":
/// [3]} or an object with the names of the columns; objects may have tmin and tmax. For points it
/// is [x, y, z], the same with max, {"position": [3]} or names. Numbers may be the texts "inf",
/// "-inf" and "nan". Empty lines are ignored. Errors: kInvalidArgument, with the file's name, the
/// line and what is wrong there.
class JsonRays : public RowReader {
 public:
  explicit JsonRays(Input input, RowKind kind = RowKind::kRays)
      : input_(std::move(input)), kind_(kind) {}

  Result<bool> next(RayRow& row) override;
  Result<bool> ready() override;
  Result<bool> wait(std::chrono::milliseconds longest) override;

 private:
  Input input_;
  RowKind kind_;
  std::uint64_t line_number_ = 0;
};

/// Parses one line. Errors: kInvalidArgument, saying what is wrong.
Status parse_json_row(std::string_view line, RayRow& row, RowKind kind = RowKind::kRays);

}  // namespace sightline::client::cli::files
