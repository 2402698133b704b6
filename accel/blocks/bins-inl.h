// The search of a large set: bins over the centers along each axis. After Wald 2007, "On fast
// Construction of SAH-based Bounding Volume Hierarchies". Compiled once per SIMD target.
#if defined(SIGHTLINE_BLOCKS_BINS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_BLOCKS_BINS_INL
#undef SIGHTLINE_BLOCKS_BINS_INL
#else
#define SIGHTLINE_BLOCKS_BINS_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "accel/blocks/pack-inl.h"
#include "accel/blocks/workspace.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

inline constexpr std::size_t kBins = 16;

/// Bins of the boxes `indices`, along all axes.
class Bins {
 public:
  HWY_INLINE Bins(const BoxLanes* boxes, const std::uint32_t* indices, std::size_t count)
      : boxes_(boxes), indices_(indices), count_(count) {
    scale_to_centers();
    if (!usable_) return;
    const Pack<8> none = Pack<8>::all(-std::numeric_limits<float>::infinity());
    for (auto& axis : unions_) {
      for (BoxLanes& bin : axis) none.store(bin.lanes);
    }
    for (std::size_t i = 0; i < count; ++i) add(boxes[indices[i]]);
  }

  /// Finds the cheapest plane between bins, by the area of a side times its groups of four. Returns
  /// false if there is none: all centers are equal, or so large that they overflow.
  HWY_INLINE bool search() {
    if (!usable_) return false;
    Pack<8> all = Pack<8>::load(unions_[0][0].lanes);
    for (std::size_t j = 1; j < kBins; ++j) all = max(all, Pack<8>::load(unions_[0][j].lanes));
    BoxLanes whole;
    all.store(whole.lanes);
    const float extent = std::max({whole.lanes[0] + whole.lanes[4], whole.lanes[1] + whole.lanes[5],
                                   whole.lanes[2] + whole.lanes[6]});
    if (!(extent <= std::numeric_limits<float>::max())) return false;
    inverse_ = std::min(1 / extent, std::numeric_limits<float>::max());
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t a = 0; a < 3; ++a) search_axis(a, least);
    return least < std::numeric_limits<float>::infinity();
  }

  /// Moves the indices on the left of the plane to the front and returns their number. `moved` has
  /// capacity for all.
  HWY_INLINE std::size_t partition(std::uint32_t* indices, std::uint32_t* moved) const {
    std::size_t left = 0, right = 0;
    const float least = least_.lanes[axis_], scale = scale_.lanes[axis_];
    const BoxLanes* const boxes = boxes_;
    const std::size_t axis = axis_, count = count_;
    const int plane = plane_;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t index = indices[i];
      const float center = boxes[index].lanes[axis + 4] - boxes[index].lanes[axis];
      const std::size_t goes_left = static_cast<int>((center - least) * scale) <= plane ? 1 : 0;
      indices[left] = index;
      moved[right] = index;
      left += goes_left;
      right += 1 - goes_left;
    }
    std::copy(moved, moved + right, indices + left);
    return left;
  }

 private:
  struct alignas(16) Quad {
    float lanes[4];
  };

  /// Twice the center of a box: the factor does not change its bin.
  static HWY_INLINE Pack<4> center(const BoxLanes& box) {
    return Pack<4>::load(box.lanes + 4) - Pack<4>::load(box.lanes);
  }

  HWY_INLINE void scale_to_centers() {
    Pack<4> lo = center(boxes_[indices_[0]]), hi = lo;
    for (std::size_t i = 1; i < count_; ++i) {
      const Pack<4> c = center(boxes_[indices_[i]]);
      lo = min(lo, c);
      hi = max(hi, c);
    }
    bool finite = true, differ = false;
    Quad extent;
    lo.store(least_.lanes);
    (hi - lo).store(extent.lanes);
    for (std::size_t a = 0; a < 3; ++a) {
      finite = finite && extent.lanes[a] <= std::numeric_limits<float>::max();
      differ = differ || extent.lanes[a] > 0;
      // The range is a little less than the number of bins, as rounding must not exceed the last
      // one.
      constexpr float kRange = static_cast<float>(kBins) - 0.01f;
      scale_.lanes[a] = extent.lanes[a] > 0
                            ? std::min(kRange / extent.lanes[a], std::numeric_limits<float>::max())
                            : 0.0f;
    }
    lowest_ = lo;
    scales_ = Pack<4>::load(scale_.lanes);
    usable_ = finite && differ;
  }

  HWY_INLINE void add(const BoxLanes& box) {
    namespace hn = hwy::HWY_NAMESPACE;
    using P = Pack<4>;
    const P position = (center(box) - lowest_) * scales_;
    alignas(16) std::int32_t bin[4];
    const hn::RebindToSigned<P::D> ints;
    for (std::size_t i = 0; i < P::kParts; ++i)
      hn::Store(hn::ConvertTo(ints, position.part[i]), ints, bin + i * P::kLanes);
    const Pack<8> lanes = Pack<8>::load(box.lanes);
    for (std::size_t a = 0; a < 3; ++a) {
      const auto j = static_cast<std::size_t>(bin[a]);
      float* const to = unions_[a][j].lanes;
      max(lanes, Pack<8>::load(to)).store(to);
      ++counts_[a][j];
    }
  }

  /// Half the surface area, relative to the square of the whole set's extent.
  HWY_INLINE float area(const Pack<8>& box) const {
    BoxLanes b;
    box.store(b.lanes);
    const float x = (b.lanes[0] + b.lanes[4]) * inverse_, y = (b.lanes[1] + b.lanes[5]) * inverse_,
                z = (b.lanes[2] + b.lanes[6]) * inverse_;
    return x * y + y * z + z * x;
  }
  HWY_INLINE float cost(const Pack<8>& box, std::uint32_t count) const {
    const std::uint32_t groups = (count + 3) / 4;
    return area(box) * static_cast<float>(groups);
  }

  HWY_INLINE void search_axis(std::size_t a, float& least) {
    float right[kBins];
    Pack<8> box = Pack<8>::load(unions_[a][kBins - 1].lanes);
    std::uint32_t count = 0;
    for (std::size_t j = kBins; j-- > 1;) {
      box = max(box, Pack<8>::load(unions_[a][j].lanes));
      count += counts_[a][j];
      right[j] = count > 0 ? cost(box, count) : std::numeric_limits<float>::infinity();
    }
    box = Pack<8>::load(unions_[a][0].lanes);
    count = 0;
    for (std::size_t j = 0; j + 1 < kBins; ++j) {
      box = max(box, Pack<8>::load(unions_[a][j].lanes));
      count += counts_[a][j];
      if (count == 0) continue;
      const float sum = cost(box, count) + right[j + 1];
      if (!(sum < least)) continue;
      least = sum;
      axis_ = a;
      plane_ = static_cast<int>(j);
    }
  }

  const BoxLanes* boxes_;
  const std::uint32_t* indices_;
  std::size_t count_;
  Quad least_{}, scale_{};  ///< By axis: the least center, and bins per unit of extent.
  Pack<4> lowest_, scales_;
  bool usable_ = false;
  float inverse_ = 0;
  std::size_t axis_ = 0;
  int plane_ = 0;
  BoxLanes unions_[3][kBins];
  std::uint32_t counts_[3][kBins] = {};
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#endif  // toggle
