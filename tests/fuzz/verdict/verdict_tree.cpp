#include "tests/fuzz/verdict/verdict_tree.h"

#include <algorithm>

#include "accel/blocks/block.h"
#include "accel/blocks/frame.h"
#include "accel/mesh/face_boxes.h"

namespace sightline::tests {

using accel::geometry::Aabb;
using accel::geometry::Vec3f;
namespace blocks = accel::blocks;
namespace wide = accel::wide;

namespace {

Vec3f relative(const Vec3f& v, const Vec3f& center) {
  return {blocks::relative(v.x, center.x), blocks::relative(v.y, center.y),
          blocks::relative(v.z, center.z)};
}

Aabb relative(const Aabb& box, const Vec3f& center) {
  return {relative(box.lo, center), relative(box.hi, center)};
}

const blocks::Node* join(const blocks::Node* left, const blocks::Node* right,
                         blocks::Arena& arena) {
  blocks::Node* node = arena.node();
  node->box = left->box;
  node->box.grow(right->box);
  node->levels = static_cast<std::uint16_t>(1 + std::max(left->levels, right->levels));
  node->left = left;
  node->right = right;
  return node;
}

}  // namespace

VerdictTree::VerdictTree(const accel::geometry::MeshView& mesh) : mesh_(mesh) {
  std::vector<accel::kdtree::Reference> refs(mesh.faces.size());
  refs.resize(accel::mesh::face_references(mesh, 0, refs.size(), refs.data()));
  Aabb bounds;
  for (const accel::kdtree::Reference& ref : refs) bounds.grow(ref.bounds());
  const wide::Frame frame = wide::frame_of(bounds);
  if (frame.scale != 1) return;
  frame_ = frame;
  const Vec3f& center = frame.center;
  blocks::BlockBuilder builder(mesh, center);
  blocks::Arena arena;
  const blocks::Node* chain = nullptr;
  for (const accel::kdtree::Reference& ref : refs) {
    const blocks::Node* leaf = builder.build({&ref, 1}, bounds, arena);
    chain = chain == nullptr ? leaf : join(chain, leaf, arena);
    boxes_.push_back(relative(ref.bounds(), center));
  }
  single_ = std::make_unique<wide::WideTree>(*chain, center);
  dense_ = std::make_unique<wide::WideTree>(*builder.build(refs, bounds, arena), center);
  list_blocks(single_->root());
  list_blocks(dense_->root());
}

std::array<Vec3f, 3> VerdictTree::corners(std::size_t face) const {
  const auto corner = [&](std::size_t k) {
    return relative(mesh_.vertices[mesh_.faces[face][k]], frame_->center);
  };
  return {corner(0), corner(1), corner(2)};
}

void VerdictTree::list_blocks(accel::kdtree::Slot at) {
  if (at.is_block()) return blocks_.push_back(at.words());
  for (std::size_t i = 0; i < accel::kdtree::kWidth && at.node()->child(i); ++i)
    list_blocks(at.node()->child(i));
}

}  // namespace sightline::tests
