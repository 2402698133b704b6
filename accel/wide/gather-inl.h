// The corners of a block's triangles, by the indices that the block has.
#if defined(SIGHTLINE_WIDE_GATHER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_GATHER_INL
#undef SIGHTLINE_WIDE_GATHER_INL
#else
#define SIGHTLINE_WIDE_GATHER_INL
#endif

#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using Floats = Lanes<float, 16>;

/// Numbers of a column of vertices, one for each triangle.
class Gather {
 public:
  HWY_INLINE explicit Gather(const std::uint8_t* corners) {
    for (std::size_t i = 0; i < Floats::kVectors; ++i) {
      const hn::Rebind<std::uint8_t, Floats::D> bytes;
      // Behind the last triangle are other numbers, for which any vertex will do.
      index_[i] = hn::And(hn::PromoteTo(kInts, hn::LoadU(bytes, corners + i * Floats::kPer)),
                          hn::Set(kInts, blocks::kBlockVertices - 1));
    }
  }

  HWY_INLINE Floats operator()(const Floats& vertices, const float* stored) const {
    if constexpr (Floats::kVectors == 1) {
      (void)stored;
      return Floats::each([&](std::size_t i) {
        return hn::TableLookupLanes(vertices.v[i],
                                    hn::IndicesFromVec(typename Floats::D(), index_[i]));
      });
    } else {
      return Floats::each(
          [&](std::size_t i) { return hn::GatherIndex(typename Floats::D(), stored, index_[i]); });
    }
  }

 private:
  static constexpr hn::RebindToSigned<Floats::D> kInts{};
  hn::Vec<hn::RebindToSigned<Floats::D>> index_[Floats::kVectors];
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
