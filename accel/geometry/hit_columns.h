// Where the fields of hits go: columns of a message or the members of an array of structs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "accel/geometry/ray.h"

namespace sightline::accel::geometry {

/// Room for a T of each ray, in memory that the column does not own. Any alignment.
template <class T>
struct FieldColumn {
  void* data = nullptr;            ///< The field of the first ray; null if not asked for.
  std::size_t stride = sizeof(T);  ///< Bytes from ray to ray.

  bool is_asked() const { return data != nullptr; }
  std::byte* at(std::size_t ray) const { return static_cast<std::byte*>(data) + ray * stride; }
  /// Sets the field of one ray. The field must be asked for.
  void set(std::size_t ray, const T& value) const { std::memcpy(at(ray), &value, sizeof(T)); }
};

/// The fields of hits (struct Hit), a column each.
struct HitColumns {
  std::size_t size = 0;  ///< The number of rays.
  FieldColumn<double> t;
  FieldColumn<std::uint64_t> node;
  FieldColumn<std::uint32_t> primitive;
  FieldColumn<std::array<float, 2>> barycentric;  ///< u and v.
  FieldColumn<Vec3f> normal;
  FieldColumn<std::uint32_t> work;
  FieldColumn<HitState> state;
  /// Bit i % 8 of byte i / 8 is set where ray i hits; bits beyond the last ray are 0. Null if not
  /// asked for.
  std::uint8_t* bits = nullptr;

  bool has_surface() const { return barycentric.is_asked() || normal.is_asked(); }
  /// Sets the asked fields of one ray. Threads: not with another ray of the same byte of bits.
  void set(std::size_t ray, const Hit& hit) const {
    if (t.is_asked()) t.set(ray, hit.t);
    if (node.is_asked()) node.set(ray, hit.node);
    if (primitive.is_asked()) primitive.set(ray, hit.primitive);
    if (barycentric.is_asked()) barycentric.set(ray, {hit.u, hit.v});
    if (normal.is_asked()) normal.set(ray, hit.normal);
    if (work.is_asked()) work.set(ray, hit.work);
    if (state.is_asked()) state.set(ray, hit.state);
    if (bits == nullptr) return;
    const auto bit = static_cast<std::uint8_t>(1u << ray % 8);
    std::uint8_t& byte = bits[ray / 8];
    byte = static_cast<std::uint8_t>(hit.state == HitState::kHit ? byte | bit : byte & ~bit);
  }
};

/// The members of an array of structs.
inline HitColumns columns_of(std::span<Hit> hits) {
  static_assert(offsetof(Hit, v) == offsetof(Hit, u) + sizeof(float));
  if (hits.empty()) return {};
  const auto member = [&](std::size_t offset) -> void* {
    return reinterpret_cast<std::byte*>(hits.data()) + offset;
  };
  constexpr std::size_t kStride = sizeof(Hit);
  return {.size = hits.size(),
          .t = {member(offsetof(Hit, t)), kStride},
          .node = {member(offsetof(Hit, node)), kStride},
          .primitive = {member(offsetof(Hit, primitive)), kStride},
          .barycentric = {member(offsetof(Hit, u)), kStride},
          .normal = {member(offsetof(Hit, normal)), kStride},
          .work = {member(offsetof(Hit, work)), kStride},
          .state = {member(offsetof(Hit, state)), kStride}};
}

}  // namespace sightline::accel::geometry
