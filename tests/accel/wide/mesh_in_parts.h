// A mesh whose tree ends at slots.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "accel/kdtree/deferred_cell.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/accel/wide/rule_over_mesh.h"

namespace sightline::tests {

/// A mesh in parts, each the subtree of a slot, below nodes.
class MeshInParts {
 public:
  MeshInParts(const TestMesh& mesh, std::size_t parts) : of(mesh), groups_(kWidth) {
    std::vector<accel::kdtree::Reference> refs(mesh.faces.size());
    refs.resize(accel::mesh::face_references(of.mesh.view(), 0, refs.size(), refs.data()));
    accel::blocks::BlockBuilder builder(of.mesh.view(), of.frame.center);
    std::vector<accel::geometry::Aabb> boxes(kWidth);
    const std::size_t in_group = (parts + kWidth - 1) / kWidth;
    for (std::size_t i = 0; i < parts; ++i) {
      const std::size_t begin = refs.size() * i / parts, end = refs.size() * (i + 1) / parts;
      accel::blocks::Arena arena;
      subtrees.push_back(std::make_unique<accel::wide::WideTree>(
          *builder.build(std::span(refs).subspan(begin, end - begin), of.bounds, arena),
          of.frame.center));
      ends.push_back(end);
      const std::size_t group = i / in_group, at = i % in_group;
      groups_[group].set_box(at, in_frame(of.frame, subtrees.back()->box()));
      boxes[group].grow(subtrees.back()->box());
      slots.push_back(&groups_[group].children[at]);
      open(i);
    }
    for (std::size_t group = 0; group * in_group < parts; ++group) {
      top_.set_box(group, in_frame(of.frame, boxes[group]));
      top_.children[group] = accel::kdtree::Slot::node(&groups_[group]).bits();
    }
  }

  void finish(std::size_t part) {
    slots[part]->store(accel::kdtree::Slot::finished(subtrees[part].get()).bits());
  }
  void open(std::size_t part) { slots[part]->store(accel::kdtree::Slot::deferred(&cell_).bits()); }
  void empty(std::size_t part) { slots[part]->store(accel::kdtree::Slot::empty_list().bits()); }

  accel::wide::Child root() const {
    return accel::wide::Child::final(accel::kdtree::Slot::node(&top_));
  }
  std::size_t part_of(const accel::kdtree::AtomicSlot& slot) const {
    return static_cast<std::size_t>(std::find(slots.begin(), slots.end(), &slot) - slots.begin());
  }

  MeshAsTree of;
  std::vector<std::unique_ptr<accel::wide::WideTree>> subtrees;
  std::vector<accel::kdtree::AtomicSlot*> slots;
  std::vector<std::size_t> ends;  ///< The first face of the next part.

 private:
  static constexpr std::size_t kWidth = accel::kdtree::kWidth;

  accel::kdtree::DeferredCell cell_;  ///< Stands for those of all parts that are open.
  std::vector<accel::kdtree::WideNode> groups_;
  accel::kdtree::WideNode top_;
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
