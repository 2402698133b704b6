// A fixed number of floats in as few vectors as a target needs. Compiled once per SIMD target.
#if defined(SIGHTLINE_BLOCKS_PACK_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_BLOCKS_PACK_INL
#undef SIGHTLINE_BLOCKS_PACK_INL
#else
#define SIGHTLINE_BLOCKS_PACK_INL
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// Four or eight floats.
template <std::size_t kCount>
struct Pack {
  using D = hwy::HWY_NAMESPACE::CappedTag<float, kCount>;
  using V = hwy::HWY_NAMESPACE::Vec<D>;
  static constexpr std::size_t kLanes = hwy::HWY_NAMESPACE::MaxLanes(D());
  static constexpr std::size_t kParts = kCount / kLanes;

  static HWY_INLINE Pack load(const float* from) {
    Pack p;
    for (std::size_t i = 0; i < kParts; ++i)
      p.part[i] = hwy::HWY_NAMESPACE::LoadU(D(), from + i * kLanes);
    return p;
  }
  static HWY_INLINE Pack all(float x) {
    Pack p;
    for (V& part : p.part) part = hwy::HWY_NAMESPACE::Set(D(), x);
    return p;
  }
  HWY_INLINE void store(float* to) const {
    for (std::size_t i = 0; i < kParts; ++i)
      hwy::HWY_NAMESPACE::StoreU(part[i], D(), to + i * kLanes);
  }

  V part[kParts];
};

template <std::size_t kCount>
HWY_INLINE Pack<kCount> max(Pack<kCount> a, const Pack<kCount>& b) {
  for (std::size_t i = 0; i < a.kParts; ++i)
    a.part[i] = hwy::HWY_NAMESPACE::Max(a.part[i], b.part[i]);
  return a;
}
template <std::size_t kCount>
HWY_INLINE Pack<kCount> min(Pack<kCount> a, const Pack<kCount>& b) {
  for (std::size_t i = 0; i < a.kParts; ++i)
    a.part[i] = hwy::HWY_NAMESPACE::Min(a.part[i], b.part[i]);
  return a;
}
template <std::size_t kCount>
HWY_INLINE Pack<kCount> operator-(Pack<kCount> a, const Pack<kCount>& b) {
  for (std::size_t i = 0; i < a.kParts; ++i)
    a.part[i] = hwy::HWY_NAMESPACE::Sub(a.part[i], b.part[i]);
  return a;
}
template <std::size_t kCount>
HWY_INLINE Pack<kCount> operator*(Pack<kCount> a, const Pack<kCount>& b) {
  for (std::size_t i = 0; i < a.kParts; ++i)
    a.part[i] = hwy::HWY_NAMESPACE::Mul(a.part[i], b.part[i]);
  return a;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#endif  // toggle
