// The table of columns.
#include "client/cli/files/hit_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <optional>
#include <type_traits>

#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::array<HitColumnInfo, 19> kColumns{{{"ray", "<u8", 8},
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
                                                  {"signed", "<f8", 8},
                                                  {"inside", "|u1", 1},
                                                  {"votes", "|u1", 1},
                                                  {"hit", "|u1", 1},
                                                  {"work", "<u4", 4},
                                                  {"count", "<u4", 4}}};
constexpr HitColumnInfo kPoint{"point", "<u8", 8}, kDistance{"distance", "<f8", 8};

bool is_side(HitColumn column) {
  return column >= HitColumn::kSigned && column <= HitColumn::kVotes;
}

bool is_of_rays(HitColumn column) {
  const bool is_position = column >= HitColumn::kX && column <= HitColumn::kZ;
  return !is_position && column != HitColumn::kName && !is_side(column);
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
    case HitColumn::kSigned:
      return use(hits.signed_distance[i]);
    case HitColumn::kInside:
      return use(hits.inside[i]);
    case HitColumn::kVotes:
      return use(hits.votes[i]);
    case HitColumn::kHit:
      return use(hits.hit[i]);
    case HitColumn::kWork:
      return use(hits.work[i] & ~kSawDeferred);
    case HitColumn::kCount:
      return use(hits.count[i]);
  }
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
  if (asked == RowKind::kPoints && kind == QueryKind::kClosest)
    known.insert(known.end(), {HitColumn::kSigned, HitColumn::kInside, HitColumn::kVotes});
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
      case HitColumn::kSigned:
        fields.signed_distance = true;
        break;
      case HitColumn::kInside:
        fields.inside = true;
        break;
      case HitColumn::kVotes:
        fields.votes = true;
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

}  // namespace sightline::client::cli::files
