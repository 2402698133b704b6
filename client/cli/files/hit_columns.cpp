// The table of columns, and the rows of a cast of all hits.
#include "client/cli/files/hit_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::array<HitColumnInfo, 16> kColumns{{{"ray", "<u8", 8},
                                                  {"t", "<f8", 8},
                                                  {"node", "<u8", 8},
                                                  {"primitive", "<u4", 4},
                                                  {"u", "<f4", 4},
                                                  {"v", "<f4", 4},
                                                  {"x", "<f8", 8},
                                                  {"y", "<f8", 8},
                                                  {"z", "<f8", 8},
                                                  {"nx", "<f4", 4},
                                                  {"ny", "<f4", 4},
                                                  {"nz", "<f4", 4},
                                                  {"name", "", 0},
                                                  {"hit", "|u1", 1},
                                                  {"work", "<u4", 4},
                                                  {"count", "<u4", 4}}};
constexpr HitColumnInfo kPoint{"point", "<u8", 8}, kDistance{"distance", "<f8", 8};

bool is_of_rays(HitColumn column) {
  return column != HitColumn::kName && (column < HitColumn::kX || column > HitColumn::kZ);
}

std::optional<HitColumn> column_named(std::string_view name, RowKind asked) {
  for (std::size_t k = 0; k < kColumns.size(); ++k) {
    const auto column = static_cast<HitColumn>(k);
    if (asked == RowKind::kRays && !is_of_rays(column)) continue;
    if (info_of(column, asked).name == name) return column;
  }
  return {};
}

// Calls `use` with the value in row i, in the type of the column.
template <class Use>
void visit_value(const RowView& hits, std::size_t i, HitColumn column, Use use) {
  switch (column) {
    case HitColumn::kRay:
      return use(hits.ray[i]);
    case HitColumn::kT:
      return use(hits.t[i]);
    case HitColumn::kNode:
      return use(hits.node[i]);
    case HitColumn::kPrimitive:
      return use(hits.primitive[i]);
    case HitColumn::kU:
      return use(hits.barycentric[2 * i]);
    case HitColumn::kV:
      return use(hits.barycentric[2 * i + 1]);
    case HitColumn::kX:
      return use(hits.position[3 * i]);
    case HitColumn::kY:
      return use(hits.position[3 * i + 1]);
    case HitColumn::kZ:
      return use(hits.position[3 * i + 2]);
    case HitColumn::kNx:
      return use(hits.normal[3 * i]);
    case HitColumn::kNy:
      return use(hits.normal[3 * i + 1]);
    case HitColumn::kNz:
      return use(hits.normal[3 * i + 2]);
    case HitColumn::kName:
      return use(name_of(hits, i));
    case HitColumn::kHit:
      return use(hits.hit[i]);
    case HitColumn::kWork:
      return use(hits.work[i] & ~kSawDeferred);
    case HitColumn::kCount:
      return use(hits.count[i]);
  }
}

constexpr std::uint8_t kBadRay = 2;
/// Beyond every list of names.
constexpr std::uint32_t kNoName = std::numeric_limits<std::uint32_t>::max();

template <class T>
void add_rows(std::span<const T> from, std::size_t begin, std::size_t end, std::size_t width,
              std::vector<T>& to) {
  if (from.empty()) return;
  to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(begin * width),
            from.begin() + static_cast<std::ptrdiff_t>(end * width));
}

}  // namespace

const HitColumnInfo& info_of(HitColumn column, RowKind asked) {
  if (asked == RowKind::kPoints && column == HitColumn::kT) return kDistance;
  if (asked == RowKind::kPoints && column == HitColumn::kRay) return kPoint;
  return kColumns[static_cast<std::size_t>(column)];
}

std::vector<HitColumn> all_closest_columns() {
  return {HitColumn::kT, HitColumn::kNode, HitColumn::kPrimitive, HitColumn::kU,
          HitColumn::kV, HitColumn::kNx,   HitColumn::kNy,        HitColumn::kNz};
}

std::vector<HitColumn> standard_columns(QueryKind kind, RowKind asked) {
  if (kind == QueryKind::kAny) return {HitColumn::kHit};
  if (kind == QueryKind::kCount) return {HitColumn::kCount};
  std::vector<HitColumn> columns = all_closest_columns();
  if (asked == RowKind::kPoints) {
    columns.resize(5);  // up to v
    columns.insert(columns.end(), {HitColumn::kX, HitColumn::kY, HitColumn::kZ});
  }
  if (kind == QueryKind::kAll) columns.insert(columns.begin(), HitColumn::kRay);
  return columns;
}

Status check_columns(const std::vector<HitColumn>& columns, QueryKind kind, RowKind asked) {
  std::vector<HitColumn> known = standard_columns(kind, asked);
  known.insert(known.end(), {HitColumn::kHit, HitColumn::kWork});
  const bool has_faces = kind == QueryKind::kClosest || kind == QueryKind::kAll;
  if (asked == RowKind::kPoints && has_faces) {
    known.insert(known.end(), {HitColumn::kNx, HitColumn::kNy, HitColumn::kNz, HitColumn::kName});
  }
  for (const HitColumn column : columns) {
    if (std::find(known.begin(), known.end(), column) != known.end()) continue;
    return local_error(fmt::format("this kind of {} has no '{}'",
                                   asked == RowKind::kRays ? "cast" : "query",
                                   info_of(column, asked).name));
  }
  return {};
}

Result<std::vector<HitColumn>> parse_hit_columns(std::string_view names, RowKind asked) {
  std::vector<HitColumn> columns;
  while (true) {
    const std::size_t comma = names.find(',');
    const std::string_view name = names.substr(0, comma);
    const auto column = column_named(name, asked);
    if (!column) return local_error(fmt::format("'{}' is not a field", name));
    if (std::find(columns.begin(), columns.end(), *column) != columns.end()) {
      return local_error(fmt::format("field '{}' is there twice", name));
    }
    columns.push_back(*column);
    if (comma == std::string_view::npos) break;
    names.remove_prefix(comma + 1);
  }
  std::sort(columns.begin(), columns.end());
  return columns;
}

HitFields fields_for(const std::vector<HitColumn>& columns) {
  HitFields fields;
  for (const HitColumn column : columns) {
    switch (column) {
      case HitColumn::kT:
        fields.t = true;
        break;
      case HitColumn::kNode:
        fields.node = true;
        break;
      case HitColumn::kPrimitive:
        fields.primitive = true;
        break;
      case HitColumn::kU:
      case HitColumn::kV:
        fields.barycentric = true;
        break;
      case HitColumn::kX:
      case HitColumn::kY:
      case HitColumn::kZ:
        fields.position = true;
        break;
      case HitColumn::kName:
        fields.name = true;
        break;
      case HitColumn::kNx:
      case HitColumn::kNy:
      case HitColumn::kNz:
        fields.normal = true;
        break;
      case HitColumn::kHit:
        fields.hit = true;
        break;
      case HitColumn::kWork:
        fields.work = true;
        break;
      case HitColumn::kCount:
        fields.count = true;
        break;
      case HitColumn::kRay:  // needs no field: the row tells it
        break;
    }
  }
  return fields;
}

std::string_view name_of(const RowView& hits, std::size_t i) {
  const std::uint32_t row = hits.name[i];
  return row < hits.names.size() ? hits.names[row] : std::string_view();
}

void put_bytes(const RowView& hits, std::size_t i, HitColumn column, char* out) {
  visit_value(hits, i, column, [&](auto value) {
    if constexpr (std::is_arithmetic_v<decltype(value)>) std::memcpy(out, &value, sizeof(value));
  });
}

void put_text(const RowView& hits, std::size_t i, HitColumn column, std::string& out) {
  // The shortest text that reads back as the same number.
  visit_value(hits, i, column,
              [&](auto value) { fmt::format_to(std::back_inserter(out), "{}", value); });
}

RowView HitRows::make(std::uint64_t first, const HitView& hits) {
  ray_.clear();
  node_.clear();
  t_.clear();
  primitive_.clear();
  work_.clear();
  barycentric_.clear();
  position_.clear();
  normal_.clear();
  name_.clear();
  hit_.clear();
  for (std::size_t i = 0; i + 1 < hits.offsets.size(); ++i) {
    if (hits.hit[i] == kBadRay) {
      add_without_hit(std::numeric_limits<double>::quiet_NaN());
    } else if (hits.hit[i] == kUnanswered) {
      add_without_hit(-std::numeric_limits<double>::infinity());
    } else {
      add_hits(hits, i);
    }
    hit_.resize(t_.size(), hits.hit[i]);
    ray_.resize(t_.size(), first + i);
    if (!hits.work.empty()) work_.resize(t_.size(), hits.work[i]);
  }
  RowView rows;
  rows.ray = ray_;
  rows.t = t_;
  rows.node = node_;
  rows.primitive = primitive_;
  rows.barycentric = barycentric_;
  rows.position = position_;
  rows.normal = normal_;
  rows.name = name_;
  rows.names = hits.names;
  rows.hit = hit_;
  rows.work = work_;
  return rows;
}

void HitRows::add_without_hit(double t) {
  t_.push_back(t);
  node_.push_back(0);
  primitive_.push_back(0);
  barycentric_.insert(barycentric_.end(), 2, 0.0F);
  position_.insert(position_.end(), 3, std::numeric_limits<double>::quiet_NaN());
  normal_.insert(normal_.end(), 3, 0.0F);
  name_.push_back(kNoName);
}

void HitRows::add_hits(const HitView& hits, std::size_t i) {
  const std::size_t begin = hits.offsets[i], end = hits.offsets[i + 1];
  if (hits.t.empty()) {
    t_.resize(t_.size() + end - begin);  // counts the rows even if t was not requested
  } else {
    add_rows(hits.t, begin, end, 1, t_);
  }
  add_rows(hits.node, begin, end, 1, node_);
  add_rows(hits.primitive, begin, end, 1, primitive_);
  add_rows(hits.barycentric, begin, end, 2, barycentric_);
  add_rows(hits.position, begin, end, 3, position_);
  add_rows(hits.normal, begin, end, 3, normal_);
  add_rows(hits.name, begin, end, 1, name_);
}

}  // namespace sightline::client::cli::files
