// One table of columns.
#include "client/cli/files/hit_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <optional>

#include "client/cli/exit_code.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::array<HitColumnInfo, 12> kColumns{{{"ray", "<u8", 8},
                                                  {"t", "<f8", 8},
                                                  {"node", "<u8", 8},
                                                  {"primitive", "<u4", 4},
                                                  {"u", "<f4", 4},
                                                  {"v", "<f4", 4},
                                                  {"nx", "<f4", 4},
                                                  {"ny", "<f4", 4},
                                                  {"nz", "<f4", 4},
                                                  {"hit", "|u1", 1},
                                                  {"work", "<u4", 4},
                                                  {"count", "<u4", 4}}};

std::optional<HitColumn> column_named(std::string_view name) {
  for (std::size_t k = 0; k < kColumns.size(); ++k) {
    if (kColumns[k].name == name) return static_cast<HitColumn>(k);
  }
  return {};
}

// Calls `use` with the value, in the type of the column.
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
    case HitColumn::kNx:
      return use(hits.normal[3 * i]);
    case HitColumn::kNy:
      return use(hits.normal[3 * i + 1]);
    case HitColumn::kNz:
      return use(hits.normal[3 * i + 2]);
    case HitColumn::kHit:
      return use(hits.hit[i]);
    case HitColumn::kWork:
      return use(hits.work[i] & ~kMetUnbuilt);
    case HitColumn::kCount:
      return use(hits.count[i]);
  }
}

}  // namespace

const HitColumnInfo& info_of(HitColumn column) {
  return kColumns[static_cast<std::size_t>(column)];
}

std::vector<HitColumn> all_closest_columns() {
  return {HitColumn::kT, HitColumn::kNode, HitColumn::kPrimitive, HitColumn::kU,
          HitColumn::kV, HitColumn::kNx,   HitColumn::kNy,        HitColumn::kNz};
}

std::vector<HitColumn> standard_columns(QueryKind kind) {
  if (kind == QueryKind::kAny) return {HitColumn::kHit};
  if (kind == QueryKind::kCount) return {HitColumn::kCount};
  std::vector<HitColumn> columns = all_closest_columns();
  if (kind == QueryKind::kAll) columns.insert(columns.begin(), HitColumn::kRay);
  return columns;
}

Status check_columns(const std::vector<HitColumn>& columns, QueryKind kind) {
  std::vector<HitColumn> known = standard_columns(kind);
  known.insert(known.end(), {HitColumn::kHit, HitColumn::kWork});
  for (const HitColumn column : columns) {
    if (std::find(known.begin(), known.end(), column) != known.end()) continue;
    return local_error(fmt::format("this kind of cast has no '{}'", info_of(column).name));
  }
  return {};
}

Result<std::vector<HitColumn>> parse_hit_columns(std::string_view names) {
  std::vector<HitColumn> columns;
  while (true) {
    const std::size_t comma = names.find(',');
    const std::string_view name = names.substr(0, comma);
    const auto column = column_named(name);
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
      case HitColumn::kRay:  // by the place of its rows
        break;
    }
  }
  return fields;
}

void put_bytes(const RowView& hits, std::size_t i, HitColumn column, char* out) {
  visit_value(hits, i, column, [&](auto value) { std::memcpy(out, &value, sizeof(value)); });
}

void put_text(const RowView& hits, std::size_t i, HitColumn column, std::string& out) {
  // The shortest text that reads back as the same number.
  visit_value(hits, i, column,
              [&](auto value) { fmt::format_to(std::back_inserter(out), "{}", value); });
}

}  // namespace sightline::client::cli::files
