// A mesh whose tree ends at slots.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/accel/wide/rule_over_mesh.h"

namespace sightline::tests {

/// A mesh in parts, each the subtree of a slot, below one wide tree.
class MeshInParts {
 public:
  MeshInParts(const TestMesh& mesh, std::size_t parts) : of(mesh) {
    std::vector<accel::kdtree::Reference> refs(mesh.faces.size());
    refs.resize(accel::mesh::face_references(of.mesh.view(), 0, refs.size(), refs.data()));
    accel::blocks::BlockBuilder builder(of.mesh.view(), of.frame.center);
    const accel::blocks::Node* root = nullptr;
    for (std::size_t i = 0; i < parts; ++i) {
      const std::size_t begin = refs.size() * i / parts, end = refs.size() * (i + 1) / parts;
      accel::blocks::Arena arena;
      subtrees.push_back(std::make_unique<accel::wide::WideTree>(
          *builder.build(std::span(refs).subspan(begin, end - begin), of.bounds, arena),
          of.frame.center));
      slots.emplace_back(accel::kdtree::Slot::empty_leaf().bits());
      ends.push_back(end);
      const accel::blocks::Node* leaf = leaf_over(slots.back(), subtrees.back()->box());
      root = root == nullptr ? leaf : join(root, leaf);
    }
    top = std::make_unique<accel::wide::WideTree>(*root, of.frame.center);
  }

  void finish(std::size_t part) {
    slots[part].store(accel::kdtree::Slot::finished(subtrees[part].get()).bits());
  }

  std::size_t part_of(const accel::kdtree::AtomicSlot& slot) const {
    for (std::size_t i = 0; i < slots.size(); ++i) {
      if (&slots[i] == &slot) return i;
    }
    return slots.size();
  }

  MeshAsTree of;
  std::vector<std::unique_ptr<accel::wide::WideTree>> subtrees;
  std::deque<accel::kdtree::AtomicSlot> slots;
  std::vector<std::size_t> ends;  ///< The first face of the next part.
  std::unique_ptr<accel::wide::WideTree> top;

 private:
  const accel::blocks::Node* leaf_over(const accel::kdtree::AtomicSlot& slot,
                                       const accel::geometry::Aabb& box) {
    accel::blocks::Node* leaf = arena_.node();
    leaf->box = box;
    leaf->words = accel::blocks::Node::kOther;
    leaf->other = accel::wide::Child::slot(&slot).bits();
    return leaf;
  }

  const accel::blocks::Node* join(const accel::blocks::Node* left,
                                  const accel::blocks::Node* right) {
    return arena_.join(left, right);
  }

  accel::blocks::Arena arena_;
};

/// The rule over the faces of the parts that count.
template <class Counts>
Answer search(const MeshInParts& parts, const accel::geometry::Ray& ray, bool any,
              const Counts& counts) {
  const TestMesh& mesh = parts.of.mesh;
  Answer best;
  for (std::size_t part = 0, i = 0; i < mesh.faces.size(); ++i) {
    if (i == parts.ends[part]) ++part;
    if (!counts(part)) continue;
    const std::optional<double> t = hit(mesh, i, ray, accel::geometry::Culling::kNone);
    if (!t || (best.found && *t >= best.t)) continue;
    if (any) return {true};
    best = {true, *t, static_cast<std::uint32_t>(i)};
  }
  return best;
}

}  // namespace sightline::tests
