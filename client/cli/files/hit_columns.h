// The columns of a hit file: names, types, order, and the rows of a cast of all hits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/cast_options.h"
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

/// A row a hit, and for a bad ray one row with t = NaN and node 0, so that a file tells it from a
/// miss, which has none. `hit` and `work` are those of the ray, in each of its rows. The memory is
/// used again by the next answers.
class HitRows {
 public:
  /// `hits` answers rays from number `first` on, and has offsets and `hit`. What is returned lives
  /// until the next call.
  RowView make(std::uint64_t first, const HitView& hits);
  std::size_t size() const { return ray_.size(); }

 private:
  void add_bad_ray();
  void add_hits(const HitView& hits, std::size_t i);

  std::vector<std::uint64_t> ray_, node_;
  std::vector<double> t_;
  std::vector<std::uint32_t> primitive_, work_;
  std::vector<float> barycentric_, normal_;
  std::vector<std::uint8_t> hit_;
};

}  // namespace sightline::client::cli::files
