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

#include "client/cli/terminal.h"

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
    case HitColumn::kNx:
      return use(hits.normal[3 * i]);
    case HitColumn::kNy:
      return use(hits.normal[3 * i + 1]);
    case HitColumn::kNz:
      return use(hits.normal[3 * i + 2]);
    case HitColumn::kHit:
      return use(hits.hit[i]);
    case HitColumn::kWork:
      return use(hits.work[i] & ~kSawDeferred);
    case HitColumn::kCount:
      return use(hits.count[i]);
  }
}

constexpr std::uint8_t kBadRay = 2;

template <class T>
void add_rows(std::span<const T> from, std::size_t begin, std::size_t end, std::size_t width,
              std::vector<T>& to) {
  if (from.empty()) return;
  to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(begin * width),
            from.begin() + static_cast<std::ptrdiff_t>(end * width));
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
      case HitColumn::kRay:  // needs no field: the row tells it
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

RowView HitRows::make(std::uint64_t first, const HitView& hits) {
  ray_.clear();
  node_.clear();
  t_.clear();
  primitive_.clear();
  work_.clear();
  barycentric_.clear();
  normal_.clear();
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
  rows.normal = normal_;
  rows.hit = hit_;
  rows.work = work_;
  return rows;
}

void HitRows::add_without_hit(double t) {
  t_.push_back(t);
  node_.push_back(0);
  primitive_.push_back(0);
  barycentric_.insert(barycentric_.end(), 2, 0.0F);
  normal_.insert(normal_.end(), 3, 0.0F);
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
  add_rows(hits.normal, begin, end, 3, normal_);
}

}  // namespace sightline::client::cli::files
