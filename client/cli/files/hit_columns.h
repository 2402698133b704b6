// The columns that hits are written in: their names, types and order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/cast_options.h"
#include "client/rays.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// In the order in which files have them.
enum class HitColumn : std::uint8_t {
  kRay,
  kT,
  kNode,
  kPrimitive,
  kU,
  kV,
  kNx,
  kNy,
  kNz,
  kHit,
  kWork,
  kCount
};

struct HitColumnInfo {
  std::string_view name;
  std::string_view type;  ///< NumPy's.
  std::size_t bytes;
};
const HitColumnInfo& info_of(HitColumn column);

/// All that a closest hit has, `work` left out.
std::vector<HitColumn> all_closest_columns();
/// What an answer of this kind has if nothing is said.
std::vector<HitColumn> standard_columns(QueryKind kind);
/// Errors: kInvalidArgument, naming the column, if answers of this kind do not have one of them.
Status check_columns(const std::vector<HitColumn>& columns, QueryKind kind);

/// From names parted by commas, put in the order of files. Errors: kInvalidArgument, naming the
/// word, for one that is no column or is there twice.
Result<std::vector<HitColumn>> parse_hit_columns(std::string_view names);

/// What has to be asked of the server for these columns.
HitFields fields_for(const std::vector<HitColumn>& columns);

/// Rows of a file: every column has a row for each.
struct RowView : HitView {
  RowView() = default;
  RowView(const HitView& hits) : HitView(hits) {}  // NOLINT: answers with a row a ray are rows

  std::span<const std::uint64_t> ray{};  ///< Number of the ray that the row answers.
};

/// Writes the column's value in row i as its bytes, and as text.
void put_bytes(const RowView& hits, std::size_t i, HitColumn column, char* out);
void put_text(const RowView& hits, std::size_t i, HitColumn column, std::string& out);

}  // namespace sightline::client::cli::files
