// How rows of hits become the bytes of a file, in each format.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/files/format.h"
#include "client/cli/files/hit_columns.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// The format of one file. Rows are added in order.
class HitFormat {
 public:
  virtual ~HitFormat() = default;

  /// The first bytes of a file with that number of rows. The length is the same for every number.
  virtual std::string header(std::uint64_t rows) const = 0;
  /// Whether rows must have `lines`.
  virtual bool needs_lines() const { return false; }
  /// Whether the header says how many rows there are.
  virtual bool counts_rows() const { return false; }
  /// Appends the bytes of n rows. Returns how many of them the file has.
  virtual std::size_t add(const RowView& rows, std::size_t n, std::string& bytes) = 0;
  /// The last bytes of the file. Errors: kInvalidArgument, the format cannot hold so much.
  virtual Result<std::string> finish() { return std::string(); }
};

/// Where the ray of row i hits. The rows have t and lines, and t is finite.
std::array<double, 3> hit_point(const RowView& rows, std::size_t i);

struct HitFormatOptions {
  std::vector<HitColumn> columns;
  /// The shape of the array of rows, if there are as many as it says; empty: (rows).
  std::vector<std::uint64_t> array_shape = {};
  bool names = true;  ///< CSV begins with a line of names
  RowKind asked = RowKind::kRays;
};

std::unique_ptr<HitFormat> make_hit_format(Format format, HitFormatOptions options);

}  // namespace sightline::client::cli::files
