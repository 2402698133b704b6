// The recursion: bins while a set is large, then sweeps on quantized boxes, then blocks.
#include "accel/blocks/block_builder.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/blocks/block_writer.h"
#include "accel/blocks/workspace.h"

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/blocks/block_builder.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/blocks/bins-inl.h"
#include "accel/blocks/quantize-inl.h"
#include "accel/blocks/share-inl.h"
#include "accel/blocks/sweep-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// Costs of visiting an inner node and a leaf, and of each triangle in a leaf. A leaf is tested
/// four triangles at a time, so splits are compared by groups of four.
constexpr float kInnerCost = 0.5f, kLeafCost = 1.0f, kTriangleCost = 0.05f;
/// Estimated shares of the cost of the best split, and of its triangles, that remain once the
/// splits below are made.
constexpr float kSplitGain = 0.6f, kTriangleGain = 0.5f;
/// A set is quantized again if its extents have become smaller than this.
constexpr unsigned kCoarseExtent = 24;

/// Whether a set can be divided down to single references in this many levels.
inline bool fits(std::size_t count, unsigned levels) {
  return static_cast<unsigned>(std::bit_width(count - 1)) <= levels;
}

class Growth {
 public:
  Growth(Workspace& work, const geometry::MeshView& mesh, const geometry::Vec3f& center,
         Arena& arena)
      : work_(work), mesh_(mesh), center_(center), arena_(arena) {}

  /// Grows the subtree of a range of the indices.
  const Node* grow(std::size_t first, std::size_t count, unsigned levels) {
    std::uint32_t* const indices = work_.indices.data() + first;
    if (count <= kSweptSet) {
      indices_ = indices;
      return grow_swept(count, levels);
    }
    std::size_t left = 0;
    {
      Bins bins(work_.boxes.data(), indices, count);
      if (bins.search()) left = bins.partition(indices, work_.moved.data());
    }
    if (left == 0 || !fits(std::max(left, count - left), levels - 1)) left = count / 2;
    const Node* const a = grow(first, left, levels - 1);
    return arena_.join(a, grow(first + left, count - left, levels - 1));
  }

 private:
  const Node* grow_swept(std::size_t count, unsigned levels) {
    Orders orders;
    for (std::size_t a = 0; a < 3; ++a) {
      orders.own[a] = work_.orders[0][a];
      orders.other[a] = work_.orders[1][a];
    }
    for (std::size_t i = 0; i < count; ++i) {
      orders.own[0][i] = static_cast<std::uint64_t>(i) << kIndexShift;
      for (const std::uint32_t v : mesh_.faces.data()[work_.ids.data()[indices_[i]]])
        hwy::Prefetch(mesh_.vertices.data() + v);
    }
    quantize(orders, count);
    return grow_orders(orders, count, levels);
  }

  const BoxLanes& box(std::uint64_t record) const {
    return work_.boxes.data()[indices_[index_of(record)]];
  }

  BoxLanes box_of(const std::uint64_t* records, std::size_t count) const {
    Pack<8> all = Pack<8>::load(box(records[0]).lanes);
    for (std::size_t i = 1; i < count; ++i) all = max(all, Pack<8>::load(box(records[i]).lanes));
    BoxLanes b;
    all.store(b.lanes);
    return b;
  }

  /// Quantizes the boxes of a set relative to their union, and sorts them.
  HWY_NOINLINE void quantize(const Orders& orders, std::size_t count) {
    std::uint64_t records[kSweptSet];
    const Quantizer quantizer(box_of(orders.own[0], count));
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint64_t old = orders.own[0][i];
      records[i] = quantizer.record(box(old)) | (old & kIndexMask << kIndexShift);
    }
    for (std::size_t a = 0; a < 3; ++a) sort_records(records, count, a, orders.own[a]);
  }

  /// The right side of a split grows first: growing the left side may overwrite what is behind it.
  HWY_NOINLINE const Node* grow_orders(const Orders& orders, std::size_t count, unsigned levels) {
    if (count == 1) return leaf(orders.own[0], count);
    OrderSplit split = sweep(orders, count);
    if (split.extent < kCoarseExtent && count > kBlockTriangles) {
      quantize(orders, count);
      split = sweep(orders, count);
    }
    if (count <= kBlockTriangles && leaf_pays(split, count)) {
      if (const Node* const node = leaf(orders.own[0], count)) return node;
    }
    if (!fits(std::max(split.left, count - split.left), levels - 1)) split.left = count / 2;
    const Orders divided = divide(orders, count, split);
    const Node* const right =
        grow_orders(divided.behind(split.left), count - split.left, levels - 1);
    return arena_.join(grow_orders(divided, split.left, levels - 1), right);
  }

  static bool leaf_pays(const OrderSplit& split, std::size_t count) {
    const float triangles = kTriangleCost * static_cast<float>(count);
    return split.area * (kLeafCost + triangles) <=
           split.area * (kInnerCost + triangles * kTriangleGain) +
               split.cost * (kLeafCost * kSplitGain);
  }

  /// Makes a leaf; null if the triangles have too many vertices.
  const Node* leaf(const std::uint64_t* records, std::size_t count) {
    std::uint32_t ids[kBlockTriangles];
    for (std::size_t i = 0; i < count; ++i)
      ids[i] = work_.ids.data()[indices_[index_of(records[i])]];
    SharedVertices shared;
    if (!share(mesh_, ids, count, shared)) return nullptr;
    const BoxLanes b = box_of(records, count);
    Node* const node = arena_.node();
    node->box = {{-b.lanes[0], -b.lanes[1], -b.lanes[2]}, {b.lanes[4], b.lanes[5], b.lanes[6]}};
    node->words = static_cast<std::uint32_t>(Block::words(count, shared.count));
    node->leaf_words = write_block(mesh_, center_, ids, count, shared, arena_);
    return node;
  }

  Workspace& work_;
  const geometry::MeshView& mesh_;
  const geometry::Vec3f& center_;
  Arena& arena_;
  const std::uint32_t* indices_ = nullptr;  ///< The indices of the swept set.
};

/// Loads references, and clips their boxes to the cell. A reference has its corners in the lanes
/// that they have in BoxLanes, and integers in the others.
void load(Workspace& work, const geometry::MeshView& mesh, std::span<const kdtree::Reference> refs,
          const geometry::Aabb& cell) {
  static_assert(offsetof(kdtree::Reference, lo) == 0 &&
                offsetof(kdtree::Reference, hi) == 4 * sizeof(float));
  namespace hn = hwy::HWY_NAMESPACE;
  using P = Pack<8>;
  const hn::RebindToUnsigned<P::D> bits;
  const BoxLanes least = {{-cell.hi.x, -cell.hi.y, -cell.hi.z, 0, cell.lo.x, cell.lo.y, cell.lo.z}};
  const BoxLanes most = {{-cell.lo.x, -cell.lo.y, -cell.lo.z, 0, cell.hi.x, cell.hi.y, cell.hi.z}};
  constexpr std::uint32_t kSign = 0x80000000, kAll = 0xffffffff;
  alignas(32) constexpr std::uint32_t kSigns[8] = {kSign, kSign, kSign},
                                      kUsed[8] = {kAll, kAll, kAll, 0, kAll, kAll, kAll, 0};
  const P lower = P::load(least.lanes), upper = P::load(most.lanes);
  BoxLanes* const boxes = work.boxes.data();
  std::uint32_t *const ids = work.ids.data(), *const indices = work.indices.data();
  for (std::size_t i = 0; i < refs.size(); ++i) {
    P box = P::load(&refs[i].lo.x);
    for (std::size_t p = 0; p < P::kParts; ++p) {
      const auto signs = hn::Load(bits, kSigns + p * P::kLanes);
      const auto used = hn::Load(bits, kUsed + p * P::kLanes);
      const auto lanes = hn::And(hn::Xor(hn::BitCast(bits, box.part[p]), signs), used);
      box.part[p] = hn::BitCast(P::D(), lanes);
    }
    min(max(box, lower), upper).store(boxes[i].lanes);
    ids[i] = refs[i].id;
    hwy::Prefetch(mesh.faces.data() + refs[i].id);
    indices[i] = static_cast<std::uint32_t>(i);
  }
}

const Node* build(Workspace& work, const geometry::MeshView& mesh, const geometry::Vec3f& center,
                  std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                  Arena& arena) {
  load(work, mesh, refs, cell);
  return Growth(work, mesh, center, arena).grow(0, refs.size(), kMostLevels);
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::blocks {

HWY_EXPORT(build);

BlockBuilder::BlockBuilder(const geometry::MeshView& mesh, const geometry::Vec3f& center)
    : mesh_(mesh), center_(center), work_(std::make_unique<Workspace>()) {}
BlockBuilder::~BlockBuilder() = default;
BlockBuilder::BlockBuilder(BlockBuilder&&) noexcept = default;
BlockBuilder& BlockBuilder::operator=(BlockBuilder&&) noexcept = default;

const Node* BlockBuilder::build(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                                Arena& arena) {
  work_->resize(refs.size());
  return HWY_DYNAMIC_DISPATCH(build)(*work_, mesh_, center_, refs, cell, arena);
}

}  // namespace sightline::accel::blocks
#endif  // HWY_ONCE
