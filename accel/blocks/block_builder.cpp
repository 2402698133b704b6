// The references of a cell as boxes, and the nodes and blocks that the recursion makes of them.
#include "accel/blocks/block_builder.h"

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

#include "accel/blocks/growth-inl.h"
#include "accel/blocks/share-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::blocks {
namespace HWY_NAMESPACE {

/// Costs of visiting an inner node and a leaf, and of each triangle in a leaf. A leaf is tested
/// four triangles at a time, so splits are compared by groups of four.
constexpr float kInnerCost = 0.5f, kLeafCost = 1.0f, kTriangleCost = 0.05f;
/// Estimated shares of the cost of the best split, and of its triangles, that remain once the
/// splits below are made.
constexpr float kSplitGain = 0.6f, kTriangleGain = 0.5f;
static_assert(kFineSet == kBlockTriangles);

/// Makes blocks of triangles, and nodes in an arena.
class BlockPolicy {
 public:
  BlockPolicy(const std::uint32_t* ids, const geometry::MeshView& mesh,
              const geometry::Vec3f& center, Arena& arena)
      : ids_(ids), mesh_(mesh), center_(center), arena_(arena) {}

  void begin(const std::uint32_t* indices, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) {
      for (const std::uint32_t v : mesh_.faces.data()[ids_[indices[i]]])
        hwy::Prefetch(mesh_.vertices.data() + v);
    }
  }

  static bool pays(const OrderSplit& split, std::size_t count) {
    if (count > kBlockTriangles) return false;
    const float triangles = kTriangleCost * static_cast<float>(count);
    return split.area * (kLeafCost + triangles) <=
           split.area * (kInnerCost + triangles * kTriangleGain) +
               split.cost * (kLeafCost * kSplitGain);
  }

  /// Returns null if the triangles have too many vertices.
  template <class Box>
  const Node* leaf(const std::uint32_t* indices, std::size_t count, const Box& box) {
    std::uint32_t ids[kBlockTriangles];
    for (std::size_t i = 0; i < count; ++i) ids[i] = ids_[indices[i]];
    SharedVertices shared;
    if (!share(mesh_, ids, count, shared)) return nullptr;
    const BoxLanes b = box();
    Node* const node = arena_.node();
    node->box = {{-b.lanes[0], -b.lanes[1], -b.lanes[2]}, {b.lanes[4], b.lanes[5], b.lanes[6]}};
    node->words = static_cast<std::uint32_t>(Block::words(count, shared.count));
    node->leaf_words = write_block(mesh_, center_, ids, count, shared, arena_);
    return node;
  }

  const Node* join(std::size_t, const Node* left, const Node* right) {
    return arena_.join(left, right);
  }

  template <class Left, class Right>
  static void grow_both(std::size_t, const Left& left, const Right& right) {
    left();
    right();
  }

 private:
  const std::uint32_t* ids_;
  const geometry::MeshView& mesh_;
  const geometry::Vec3f& center_;
  Arena& arena_;
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
  BlockPolicy policy(work.ids.data(), mesh, center, arena);
  return Growth(work, policy).grow(0, refs.size(), kMostLevels);
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
