// Encodes the hit columns of a reply.
#include "server/queries/hit_codec.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

namespace sightline::server::queries {
namespace {

static_assert(std::endian::native == std::endian::little,
              "columns are little-endian and are copied as they are");

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::HitState;
using scenegraph::RayTally;

static_assert(sizeof(accel::geometry::Vec3f) == 3 * sizeof(float) &&
              sizeof(accel::geometry::Vec3d) == 3 * sizeof(double) && sizeof(HitState) == 1);

constexpr std::uint8_t kCutOff = 3;

/// Writes one column: the bytes of `element(row)` for every row, from row `first` on.
template <class Row, class Element>
void write_rows(std::span<const Row> rows, std::size_t first, std::string& data, Element element) {
  using Value = decltype(element(rows[0]));
  static_assert(std::is_trivially_copyable_v<Value>);
  char* out = data.data() + first * sizeof(Value);
  for (const Row& row : rows) {
    const Value value = element(row);
    std::memcpy(out, &value, sizeof(Value));
    out += sizeof(Value);
  }
}

/// Writes a column with a row for each listed hit.
void write_hits(std::span<const Hit> hits, v1::HitField field, std::string& data) {
  switch (field) {
    case v1::HIT_FIELD_T:
      return write_rows(hits, 0, data, [](const Hit& h) { return h.t; });
    case v1::HIT_FIELD_NODE:
      return write_rows(hits, 0, data, [](const Hit& h) { return h.node; });
    case v1::HIT_FIELD_PRIMITIVE:
      return write_rows(hits, 0, data, [](const Hit& h) { return h.primitive; });
    case v1::HIT_FIELD_BARYCENTRIC:
      return write_rows(hits, 0, data, [](const Hit& h) { return std::array<float, 2>{h.u, h.v}; });
    case v1::HIT_FIELD_NORMAL:
      return write_rows(hits, 0, data, [](const Hit& h) { return h.normal; });
    default:
      return;  // no field of hits, or one of DerivedColumns
  }
}

/// Writes a column of tallies. False: the field is not of tallies.
bool write_tallies(std::span<const RayTally> tallies, std::size_t first, v1::HitField field,
                   std::string& data) {
  switch (field) {
    case v1::HIT_FIELD_COUNT:
      write_rows(tallies, first, data, [](const RayTally& r) { return r.count; });
      return true;
    case v1::HIT_FIELD_HIT:
      write_rows(tallies, first, data, [](const RayTally& r) {
        return r.cut_off ? kCutOff : static_cast<std::uint8_t>(r.state);
      });
      return true;
    case v1::HIT_FIELD_WORK:
      write_rows(tallies, first, data, [](const RayTally& r) { return r.work; });
      return true;
    default:
      return false;
  }
}

void write_offsets(std::span<const RayTally> tallies, std::string& data) {
  std::uint32_t end = 0;
  std::memcpy(data.data(), &end, sizeof(end));
  write_rows(tallies, 1, data, [&](const RayTally& r) { return end += r.count; });
}

template <class T>
void view_rows(char* data, std::size_t first, accel::geometry::FieldColumn<T>& rows) {
  rows.data = data + first * sizeof(T);
}

void view_column(v1::HitField field, char* data, std::size_t first, HitColumns& hits) {
  switch (field) {
    case v1::HIT_FIELD_T:
      return view_rows(data, first, hits.t);
    case v1::HIT_FIELD_NODE:
      return view_rows(data, first, hits.node);
    case v1::HIT_FIELD_PRIMITIVE:
      return view_rows(data, first, hits.primitive);
    case v1::HIT_FIELD_BARYCENTRIC:
      return view_rows(data, first, hits.barycentric);
    case v1::HIT_FIELD_NORMAL:
      return view_rows(data, first, hits.normal);
    case v1::HIT_FIELD_HIT:
      return view_rows(data, first, hits.state);
    case v1::HIT_FIELD_HIT_BITS:
      hits.bits = reinterpret_cast<std::uint8_t*>(data) + first / kRaysPerBitsByte;
      return;
    case v1::HIT_FIELD_WORK:
      return view_rows(data, first, hits.work);
    default:
      return;  // no field of hits, or one of DerivedColumns
  }
}

void set_unanswered(std::size_t ray, std::size_t rays, v1::CastRaysResponse& reply) {
  std::string& bits = *reply.mutable_unanswered();
  if (bits.empty()) bits.resize((rays + kRaysPerBitsByte - 1) / kRaysPerBitsByte);
  bits[ray / kRaysPerBitsByte] = static_cast<char>(
      static_cast<unsigned char>(bits[ray / kRaysPerBitsByte]) | 1u << ray % kRaysPerBitsByte);
}

}  // namespace

std::size_t column_bytes(v1::HitField field, std::size_t rays, std::size_t hits) {
  switch (field) {
    case v1::HIT_FIELD_T:
    case v1::HIT_FIELD_SIGNED:
      return hits * sizeof(Hit::t);
    case v1::HIT_FIELD_NODE:
      return hits * sizeof(Hit::node);
    case v1::HIT_FIELD_PRIMITIVE:
      return hits * sizeof(Hit::primitive);
    case v1::HIT_FIELD_BARYCENTRIC:
      return hits * (sizeof(Hit::u) + sizeof(Hit::v));
    case v1::HIT_FIELD_NORMAL:
      return hits * sizeof(Hit::normal);
    case v1::HIT_FIELD_POSITION:
      return hits * sizeof(accel::geometry::Vec3d);
    case v1::HIT_FIELD_NAME:
      return hits * sizeof(std::uint32_t);
    case v1::HIT_FIELD_HIT:
      return rays * sizeof(HitState);
    case v1::HIT_FIELD_INSIDE:
    case v1::HIT_FIELD_VOTES:
      return rays;
    case v1::HIT_FIELD_HIT_BITS:
      return (rays + kRaysPerBitsByte - 1) / kRaysPerBitsByte;
    case v1::HIT_FIELD_WORK:
    case v1::HIT_FIELD_COUNT:
      return rays * sizeof(std::uint32_t);
    case v1::HIT_FIELD_OFFSET:
      return (rays + 1) * sizeof(std::uint32_t);
    default:
      return 0;  // decode_query lets no other field through
  }
}

std::size_t element_bytes(v1::HitField field) {
  switch (field) {
    case v1::HIT_FIELD_T:
    case v1::HIT_FIELD_SIGNED:
    case v1::HIT_FIELD_NODE:
    case v1::HIT_FIELD_POSITION:
      return sizeof(std::uint64_t);
    case v1::HIT_FIELD_HIT:
    case v1::HIT_FIELD_HIT_BITS:
    case v1::HIT_FIELD_INSIDE:
    case v1::HIT_FIELD_VOTES:
      return sizeof(std::uint8_t);
    default:
      return sizeof(std::uint32_t);
  }
}

void resize_columns(std::span<const v1::HitField> fields, std::size_t rays, std::size_t hits,
                    v1::CastRaysResponse& reply) {
  const auto count = static_cast<int>(fields.size());
  while (reply.columns_size() > count) reply.mutable_columns()->RemoveLast();
  while (reply.columns_size() < count) reply.add_columns();
  for (int i = 0; i < count; ++i) {
    v1::HitColumn& column = *reply.mutable_columns(i);
    column.set_field(fields[static_cast<std::size_t>(i)]);
    column.mutable_data()->resize(column_bytes(column.field(), rays, hits));
  }
}

HitColumns view_hits(v1::CastRaysResponse& reply, std::size_t first, std::size_t rays) {
  HitColumns hits;
  hits.size = rays;
  for (v1::HitColumn& column : *reply.mutable_columns())
    view_column(column.field(), column.mutable_data()->data(), first, hits);
  // Those of rays that do not exist are not written.
  if (hits.bits != nullptr && rays % kRaysPerBitsByte != 0) hits.bits[rays / kRaysPerBitsByte] = 0;
  return hits;
}

void encode_tallies(std::span<const RayTally> tallies, std::size_t first,
                    v1::CastRaysResponse& reply) {
  for (v1::HitColumn& column : *reply.mutable_columns())
    write_tallies(tallies, first, column.field(), *column.mutable_data());
}

void encode_lists(std::span<const RayTally> tallies, std::span<const Hit> hits,
                  std::span<const v1::HitField> fields, v1::CastRaysResponse& reply) {
  resize_columns(fields, tallies.size(), hits.size(), reply);
  for (v1::HitColumn& column : *reply.mutable_columns()) {
    std::string& data = *column.mutable_data();
    if (column.field() == v1::HIT_FIELD_OFFSET) {
      write_offsets(tallies, data);
    } else if (!write_tallies(tallies, 0, column.field(), data)) {
      write_hits(hits, column.field(), data);
    }
  }
}

void mark_unanswered(std::span<const HitState> states, std::size_t first, std::size_t rays,
                     v1::CastRaysResponse& reply) {
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (states[i] == HitState::kUnanswered) set_unanswered(first + i, rays, reply);
  }
}

void mark_unanswered(std::span<const RayTally> tallies, std::size_t first, std::size_t rays,
                     v1::CastRaysResponse& reply) {
  for (std::size_t i = 0; i < tallies.size(); ++i) {
    if (tallies[i].state == HitState::kUnanswered) set_unanswered(first + i, rays, reply);
  }
}

void mark_unanswered(std::span<const scenegraph::Side> sides, std::size_t first, std::size_t rays,
                     v1::CastRaysResponse& reply) {
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (sides[i] == scenegraph::Side::kUnanswered) set_unanswered(first + i, rays, reply);
  }
}

void encode_stats(const scenegraph::TraceStats& stats, v1::CastStats& reply) {
  reply.set_rays(stats.rays + stats.unanswered);
  reply.set_hits(stats.hits);
  reply.set_invalid(stats.invalid);
  reply.set_unanswered(stats.unanswered);
  reply.set_hits_found(stats.hits_found);
  reply.set_rays_cut_off(stats.cut_off);
  reply.set_traversal_steps(stats.traversal_steps);
  reply.set_triangle_tests(stats.triangle_tests);
  reply.set_instances_entered(stats.instances_entered);
  reply.set_cells_expanded(stats.cells_expanded);
  reply.set_build_us(static_cast<std::uint64_t>(stats.build_seconds * 1e6));
}

}  // namespace sightline::server::queries
