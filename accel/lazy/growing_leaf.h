// What the rays of a packet do where a tree is not finished: the same in meshes and in scenes.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "accel/lazy/cell_query.h"
#include "accel/wide/walk.h"
#include "accel/wide/wide_tree.h"

namespace sightline::accel::lazy {

/// References of a list or a leaf that are searched between two looks at CellQuery::cancelled.
inline constexpr std::size_t kSearchStep = 1024;

/// Leaf policy of wide::walk() for one packet in one tree. What is deferred is grown, or its list
/// is searched by all rays together.
///
/// `Content`: what the tree is over. It tests, for those of the rays that Packet::left() has:
///   void leaf(span<const uint32_t> references, uint32_t lanes)
///   void references(span<const Reference>, uint32_t lanes)  a part of a list
///   void everything(const DeferredCell& root, uint32_t lanes)
///                                         the whole tree, which has no list yet
template <class Content>
class GrowingLeaf {
 public:
  /// All of these outlive it.
  GrowingLeaf(LazyTree& tree, wide::Packet& packet, CellQuery& query, kdtree::WalkCounters& walked,
              kdtree::BuildCounters& built, Content& content)
      : tree_(tree),
        packet_(packet),
        query_(query),
        built_(built),
        content_(content),
        walked_(walked) {}

  /// Takes the rays through the tree. They are prepared for it (wide::prepare()), or it stays a
  /// list.
  void walk(std::uint32_t lanes) {
    if (lanes != 0)
      wide::walk(packet_, wide::Child::at(tree_.root()), lanes, wide::Leaf(*this), walked_);
  }

  /// See wide::Leaf.
  wide::Child enter(kdtree::AtomicSlot& slot, std::uint32_t lanes) {
    const kdtree::Slot now = kdtree::load(slot);
    if (now.is_deferred() && !enter_cell(slot, *now.cell(), lanes)) return {};
    return wide::Child::at(slot);
  }
  void visit(std::span<const std::uint32_t> list, std::uint32_t lanes) {
    in_steps(list, lanes, [&](auto part) { content_.leaf(part, lanes); });
  }

 private:
  /// True: the slot has changed.
  bool enter_cell(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell, std::uint32_t lanes) {
    const AtCell does =
        meet(tree_, slot, cell, static_cast<std::uint64_t>(std::popcount(lanes)), query_, built_);
    if (does == AtCell::kAdvance) return true;
    if (does == AtCell::kStop) {
      if (tree_.is_over_faces()) {
        packet_.stopped = true;
      } else {
        packet_.suspended |= lanes;
      }
      return false;
    }
    if (does == AtCell::kSkip || !tree_.is_hierarchy(cell)) packet_.saw_deferred |= lanes;
    if (does == AtCell::kSearch) search(cell, lanes);
    return false;
  }

  void search(const kdtree::DeferredCell& cell, std::uint32_t lanes) {
    cell.last_use.use();
    const bool searched_before = std::exchange(query_.searches_list, true);
    if (!cell.has_list) {
      content_.everything(cell, lanes);
    } else if (cell.list.is_compact()) {
      visit(cell.list.ids(), lanes);
    } else {
      cell.list.any_part([&](std::span<const kdtree::Reference> refs) {
        in_steps(refs, lanes, [&](auto part) { content_.references(part, lanes); });
        return packet_.left(lanes) == 0;
      });
    }
    query_.searches_list = searched_before;
  }

  /// While there are rays left.
  template <class T, class Test>
  void in_steps(std::span<const T> all, std::uint32_t lanes, const Test& test) {
    while (!all.empty()) {
      if (query_.is_cancelled()) packet_.stopped = true;
      if (packet_.left(lanes) == 0) return;
      const auto part = all.first(std::min(all.size(), kSearchStep));
      all = all.subspan(part.size());
      test(part);
    }
  }

  LazyTree& tree_;
  wide::Packet& packet_;
  CellQuery& query_;
  kdtree::BuildCounters& built_;
  Content& content_;
  kdtree::WalkCounters& walked_;
};

}  // namespace sightline::accel::lazy
