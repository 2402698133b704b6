// The columns of a hit file: names, types, order, and values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/cast_options.h"
#include "client/cli/files/row_layout.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// The columns, in the order in which files have them.
enum class HitColumn : std::uint8_t {
  kRay,
  kT,
  kNode,
  kPrimitive,
  kU,
  kV,
  kX,
  kY,
  kZ,
  kNx,
  kNy,
  kNz,
  kName,
  kSigned,
  kInside,
  kVotes,
  kHit,
  kWork,
  kCount
};

struct HitColumnInfo {
  std::string_view name;
  std::string_view type;  ///< as NumPy writes it; empty: text
  std::size_t bytes;
};
/// For points `t` is called distance, and `ray` point.
const HitColumnInfo& info_of(HitColumn column, RowKind asked = RowKind::kRays);

/// All columns of a closest hit, without `work`.
std::vector<HitColumn> all_closest_columns();
/// The default columns for an answer of this kind.
std::vector<HitColumn> standard_columns(QueryKind kind, RowKind asked = RowKind::kRays);
/// Errors: kInvalidArgument, naming the column, if answers of this kind do not have one of the
/// columns.
Status check_columns(const std::vector<HitColumn>& columns, QueryKind kind,
                     RowKind asked = RowKind::kRays);

/// Parses names separated by commas, and sorts them into the order of files. Errors:
/// kInvalidArgument, naming the word, for an unknown column or one that occurs twice.
Result<std::vector<HitColumn>> parse_hit_columns(std::string_view names,
                                                 RowKind asked = RowKind::kRays);

/// The fields that must be requested from the server for these columns.
HitFields fields_for(const std::vector<HitColumn>& columns);

/// Rows of a file: each column has one value per row.
struct RowView : HitView {
  RowView() = default;
  RowView(const HitView& hits) : HitView(hits) {}  // NOLINT: answers with a row a ray are rows

  std::span<const std::uint64_t> ray{};  ///< the number of the ray that the row answers
  /// (n, 6) the origin and direction of the row's ray; empty for formats that do not need them
  std::span<const double> lines{};
};

/// The name of the node in row i; "" without a hit.
std::string_view name_of(const RowView& hits, std::size_t i);

/// Writes the value of the column in row i, as bytes or as text. A name has no bytes.
void put_bytes(const RowView& hits, std::size_t i, HitColumn column, char* out);
void put_text(const RowView& hits, std::size_t i, HitColumn column, std::string& out);

}  // namespace sightline::client::cli::files
