// N numbers in as many vectors as the target needs for them. Compiled once per SIMD target.
#if defined(SIGHTLINE_WIDE_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_LANES_INL
#undef SIGHTLINE_WIDE_LANES_INL
#else
#define SIGHTLINE_WIDE_LANES_INL
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// N numbers. Comparisons return a bit for each lane.
template <class T, std::size_t N>
struct Lanes {
  using D = hn::CappedTag<T, N>;
  using V = hn::Vec<D>;
  static constexpr std::size_t kPer = hn::MaxLanes(D());
  static constexpr std::size_t kVectors = N / kPer;
  static constexpr std::uint32_t kAll = static_cast<std::uint32_t>((std::uint64_t{1} << N) - 1);

  V v[kVectors];

  template <class F>
  static HWY_INLINE Lanes each(const F& f) {
    Lanes out;
    for (std::size_t i = 0; i < kVectors; ++i) out.v[i] = f(i);
    return out;
  }
  static HWY_INLINE Lanes set(T x) {
    return each([x](std::size_t) { return hn::Set(D(), x); });
  }
  /// Loads from an aligned column.
  static HWY_INLINE Lanes load(const T* from) {
    return each([from](std::size_t i) { return hn::Load(D(), from + i * kPer); });
  }
  static HWY_INLINE Lanes load_unaligned(const T* from) {
    return each([from](std::size_t i) { return hn::LoadU(D(), from + i * kPer); });
  }
  HWY_INLINE void store(T* to) const {
    for (std::size_t i = 0; i < kVectors; ++i) hn::Store(v[i], D(), to + i * kPer);
  }
  HWY_INLINE void store_unaligned(T* to) const {
    for (std::size_t i = 0; i < kVectors; ++i) hn::StoreU(v[i], D(), to + i * kPer);
  }

  template <class Compare>
  static HWY_INLINE std::uint32_t bits(const Compare& compare) {
    std::uint32_t all = 0;
    for (std::size_t i = 0; i < kVectors; ++i) {
      alignas(8) std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(D(), compare(i), bytes);
      std::uint32_t part;
      std::memcpy(&part, bytes, sizeof(part));
      all |= part << (i * kPer);
    }
    return all & kAll;
  }
  /// Takes the lanes with a bit from `yes`, the others from `no`.
  static HWY_INLINE Lanes pick(std::uint32_t chosen, const Lanes& yes, const Lanes& no) {
    return each([&](std::size_t i) {
      const std::uint64_t part = chosen >> (i * kPer);
      alignas(8) std::uint8_t bytes[8];
      std::memcpy(bytes, &part, sizeof(part));
      return hn::IfThenElse(hn::LoadMaskBits(D(), bytes), yes.v[i], no.v[i]);
    });
  }

  friend HWY_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t i) { return hn::Add(a.v[i], b.v[i]); });
  }
  friend HWY_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t i) { return hn::Sub(a.v[i], b.v[i]); });
  }
  friend HWY_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t i) { return hn::Mul(a.v[i], b.v[i]); });
  }
  friend HWY_INLINE Lanes operator/(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t i) { return hn::Div(a.v[i], b.v[i]); });
  }
  friend HWY_INLINE Lanes min(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t i) { return hn::Min(a.v[i], b.v[i]); });
  }
  friend HWY_INLINE Lanes max(const Lanes& a, const Lanes& b) {
    return each([&](std::size_t i) { return hn::Max(a.v[i], b.v[i]); });
  }
  friend HWY_INLINE Lanes neg(const Lanes& a) {
    return each([&](std::size_t i) { return hn::Neg(a.v[i]); });
  }
  friend HWY_INLINE Lanes abs(const Lanes& a) {
    return each([&](std::size_t i) { return hn::Abs(a.v[i]); });
  }
  /// a * b + c; rounded once where the target can.
  friend HWY_INLINE Lanes mul_add(const Lanes& a, const Lanes& b, const Lanes& c) {
    return each([&](std::size_t i) { return hn::MulAdd(a.v[i], b.v[i], c.v[i]); });
  }
  /// a * b - c.
  friend HWY_INLINE Lanes mul_sub(const Lanes& a, const Lanes& b, const Lanes& c) {
    return each([&](std::size_t i) { return hn::MulSub(a.v[i], b.v[i], c.v[i]); });
  }
  /// c - a * b.
  friend HWY_INLINE Lanes neg_mul_add(const Lanes& a, const Lanes& b, const Lanes& c) {
    return each([&](std::size_t i) { return hn::NegMulAdd(a.v[i], b.v[i], c.v[i]); });
  }
  /// 1 / x of a positive x. Off by at most 6 * 2^-24 of itself: what processors approximate to 1.5
  /// * 2^-12, and one step of Newton's.
  friend HWY_INLINE Lanes reciprocal(const Lanes& x) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR
    const Lanes y = each([&](std::size_t i) { return hn::ApproximateReciprocal(x.v[i]); });
    return y * neg_mul_add(x, y, set(2));
#else
    return set(1) / x;
#endif
  }
  /// 1 / sqrt(x) of a positive x, alike: off by at most 8 * 2^-24 of itself.
  friend HWY_INLINE Lanes inverse_root(const Lanes& x) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR
    const Lanes y = each([&](std::size_t i) { return hn::ApproximateReciprocalSqrt(x.v[i]); });
    return y * neg_mul_add(x * y * set(T{0.5}), y, set(T{1.5}));
#else
    return set(1) / each([&](std::size_t i) { return hn::Sqrt(x.v[i]); });
#endif
  }
  friend HWY_INLINE std::uint32_t operator<=(const Lanes& a, const Lanes& b) {
    return bits([&](std::size_t i) { return hn::Le(a.v[i], b.v[i]); });
  }
  friend HWY_INLINE std::uint32_t operator<(const Lanes& a, const Lanes& b) {
    return bits([&](std::size_t i) { return hn::Lt(a.v[i], b.v[i]); });
  }
  /// This is no operator ==, which would say whether all are equal.
  friend HWY_INLINE std::uint32_t equal(const Lanes& a, const Lanes& b) {
    return bits([&](std::size_t i) { return hn::Eq(a.v[i], b.v[i]); });
  }
  friend HWY_INLINE std::uint32_t operator>(const Lanes& a, const Lanes& b) { return b < a; }
  friend HWY_INLINE std::uint32_t operator>=(const Lanes& a, const Lanes& b) { return b <= a; }

  HWY_INLINE T least() const {
    V all = v[0];
    for (std::size_t i = 1; i < kVectors; ++i) all = hn::Min(all, v[i]);
    return hn::GetLane(hn::MinOfLanes(D(), all));
  }
  HWY_INLINE T greatest() const {
    V all = v[0];
    for (std::size_t i = 1; i < kVectors; ++i) all = hn::Max(all, v[i]);
    return hn::GetLane(hn::MaxOfLanes(D(), all));
  }
};

/// Converts, rounding to nearest.
template <std::size_t N>
HWY_INLINE Lanes<float, N> to_floats(const Lanes<double, N>& x) {
  using From = Lanes<double, N>;
  using To = Lanes<float, N>;
  const hn::Rebind<float, typename From::D> part;
#if HWY_TARGET == HWY_SCALAR
  return To::each([&](std::size_t i) { return hn::DemoteTo(part, x.v[i]); });
#else
  static_assert(To::kPer == 2 * From::kPer);
  return To::each([&](std::size_t i) {
    return hn::Combine(typename To::D(), hn::DemoteTo(part, x.v[2 * i + 1]),
                       hn::DemoteTo(part, x.v[2 * i]));
  });
#endif
}

template <std::size_t N>
HWY_INLINE Lanes<double, N> to_doubles(const Lanes<float, N>& x) {
  using To = Lanes<double, N>;
  const typename To::D d;
#if HWY_TARGET == HWY_SCALAR
  return To::each([&](std::size_t i) { return hn::PromoteTo(d, x.v[i]); });
#else
  using From = Lanes<float, N>;
  static_assert(From::kPer == 2 * To::kPer);
  return To::each([&](std::size_t i) {
    const auto half = i % 2 == 0 ? hn::LowerHalf(x.v[i / 2])
                                 : hn::UpperHalf(hn::Half<typename From::D>(), x.v[i / 2]);
    return hn::PromoteTo(d, half);
  });
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
