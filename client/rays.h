// Rays and hits as columns of plain arrays, a row a ray.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace sightline::client {

/// Scalar is `float` or `double`, const for reading.
template <class Scalar>
struct RayColumns {
  using Mask = std::conditional_t<std::is_const_v<Scalar>, const std::uint32_t, std::uint32_t>;

  std::span<Scalar> origins;     ///< (n, 3)
  std::span<Scalar> directions;  ///< (n, 3), any length but zero; t counts in this length.
  std::span<Scalar> tmin{};      ///< (n), or empty: 0
  std::span<Scalar> tmax{};      ///< (n), or empty: +inf
  std::span<Mask> masks{};       ///< (n), or empty: all ones

  std::size_t size() const { return origins.size() / 3; }
};

/// Columns of an answer. Non-empty ones are asked for; the meaning of a row is that of
/// sightline.v1.HitField.
template <bool is_const>
struct BasicHitColumns {
  template <class T>
  using Span = std::span<std::conditional_t<is_const, const T, T>>;

  Span<double> t{};                 ///< (n) in lengths of the direction; miss +inf, bad ray NaN
  Span<std::uint64_t> node{};       ///< (n) 0 for a miss
  Span<std::uint32_t> primitive{};  ///< (n) face of the node's mesh
  Span<float> barycentric{};        ///< (n, 2) weights of vertices 1 and 2
  Span<float> normal{};             ///< (n, 3) geometric, unit, by winding, world space
  Span<std::uint8_t> hit{};         ///< (n) 0 miss, 1 hit, 2 bad ray
  Span<std::uint32_t> work{};       ///< (n) steps + triangle tests; kMetUnbuilt is set beside them
  Span<std::uint32_t> count{};      ///< (n) distinct hits; kInvalidCount for a bad ray
};
using HitColumns = BasicHitColumns<false>;
/// Where all hits are asked for, t, node, primitive, barycentric and normal have a row a hit, in
/// the order of the rays, and `offsets` (n + 1) says which: those of ray i are rows offsets[i] up
/// to offsets[i + 1]. A bad ray has none.
struct HitView : BasicHitColumns<true> {
  std::span<const std::uint32_t> offsets{};
};

/// In `hit`, where all hits are asked for: there are more than max_hits, the nearest are here.
inline constexpr std::uint8_t kCutOff = 3;
/// In `count`: a bad ray.
inline constexpr std::uint32_t kInvalidCount = 0xffffffff;
/// In `work`: the ray met a cell that is not built.
inline constexpr std::uint32_t kMetUnbuilt = 0x80000000;

/// Which columns an answer is to have.
struct HitFields {
  bool t = false;
  bool node = false;
  bool primitive = false;
  bool barycentric = false;
  bool normal = false;
  bool hit = false;
  bool work = false;
  bool count = false;
};

}  // namespace sightline::client
