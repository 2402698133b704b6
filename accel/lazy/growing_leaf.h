// What the rays of a packet do where a tree is not finished: the same in meshes and in scenes.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "accel/kdtree/traverse.h"
#include "accel/lazy/cell_query.h"
#include "accel/wide/lane_ray.h"
#include "accel/wide/walk.h"
#include "accel/wide/wide_tree.h"

namespace sightline::accel::lazy {

/// References of a list or a leaf that are searched between two looks at CellQuery::cancelled.
inline constexpr std::size_t kSearchStep = 1024;

/// Leaf policy of wide::walk() for one packet in one tree. What is deferred is grown, or its list
/// is searched by all rays together; binary slots are walked by each ray alone, in doubles.
///
/// `Content`: what the tree is over. It tests, for those of the rays that Packet::left() has:
///   void leaf(span<const uint32_t> references, uint32_t lanes)
///   void references(span<const Reference>, uint32_t lanes)  a part of a list
///   void everything(uint32_t lanes)                         the whole tree, which has no list yet
template <class Content>
class GrowingLeaf {
 public:
  /// All of these outlive it.
  GrowingLeaf(LazyTree& tree, wide::Packet& packet, CellQuery& query, kdtree::WalkCounters& walked,
              kdtree::BuildCounters& built, Content& content)
      : tree_(tree),
        packet_(packet),
        query_(query),
        walked_(walked),
        built_(built),
        content_(content) {}

  /// Takes the rays through the tree. They are prepared for it (wide::prepare()), or it has no wide
  /// nodes.
  void walk(std::uint32_t lanes) {
    if (lanes == 0) return;
    // A thread that has renewed its pin may not go on in nodes that are replaced meanwhile.
    const wide::Child entry = tree_.entry();
    const bool searched_before =
        std::exchange(query_.searches_list, query_.searches_list || entry.is_node());
    wide::walk(packet_, entry, lanes, wide::Leaf(*this), walked_);
    query_.searches_list = searched_before;
  }

  /// See wide::Leaf.
  wide::Child enter(kdtree::AtomicSlot& slot, std::uint32_t lanes) {
    const kdtree::Slot now = kdtree::load(slot);
    if (now.is_leaf()) {
      std::uint32_t storage;
      if (now.leaf_count() > 0) leaf(tree_.tree().leaf(now, storage), lanes);
      return {};
    }
    if (now.is_deferred())
      return enter_cell(slot, *now.cell(), lanes) ? wide::Child::slot(&slot) : wide::Child{};
    if (now.is_finished()) return wide::Child::slot(&slot);
    each(lanes, [&](std::size_t lane) { go_alone(slot, lane); });
    return {};
  }

 private:
  /// The visitor of kdtree::walk().
  struct LaneVisit {
    GrowingLeaf& of;
    const wide::LaneRay& ray;

    double limit() const { return ray.limit(); }
    bool is_done() const { return of.packet_.left(lanes()) == 0; }
    void leaf(std::span<const std::uint32_t> ids) { of.leaf(ids, lanes()); }
    void finished(const kdtree::FinishedSubtree& subtree) {
      const wide::Child root = static_cast<const wide::WideTree&>(subtree).enter();
      wide::walk(of.packet_, root, lanes(), wide::Leaf(of), of.walked_);
    }
    bool deferred(kdtree::AtomicSlot& slot, const kdtree::DeferredCell& cell) {
      return of.enter_cell(slot, cell, lanes());
    }
    std::uint32_t lanes() const { return 1u << ray.lane(); }
  };

  template <class Visit>
  void each(std::uint32_t lanes, const Visit& visit) {
    for (lanes = packet_.left(lanes); lanes != 0; lanes = packet_.left(lanes & (lanes - 1)))
      visit(static_cast<std::size_t>(std::countr_zero(lanes)));
  }

  void go_alone(kdtree::AtomicSlot& slot, std::size_t lane) {
    const wide::LaneRay ray(packet_, lane, tree_.tree().bounds());
    if (!ray.meets()) return;
    kdtree::WalkCounters walked;
    LaneVisit visit{*this, ray};
    kdtree::walk(tree_.tree(), ray.in_tree(), slot, walked, visit);
    tree_.count_steps(walked.steps);
    packet_.work[lane] += static_cast<std::uint32_t>(walked.steps);
    walked_ += walked;
  }

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
    packet_.saw_deferred |= lanes;
    if (does == AtCell::kSearch) search(cell, lanes);
    return false;
  }

  void search(const kdtree::DeferredCell& cell, std::uint32_t lanes) {
    cell.last_use.use();
    const bool searched_before = std::exchange(query_.searches_list, true);
    if (!cell.has_list) {
      content_.everything(lanes);
    } else if (cell.list.is_compact()) {
      leaf(cell.list.ids(), lanes);
    } else {
      cell.list.any_part([&](std::span<const kdtree::Reference> refs) {
        in_steps(refs, lanes, [&](auto part) { content_.references(part, lanes); });
        return packet_.left(lanes) == 0;
      });
    }
    query_.searches_list = searched_before;
  }

  void leaf(std::span<const std::uint32_t> ids, std::uint32_t lanes) {
    in_steps(ids, lanes, [&](auto part) { content_.leaf(part, lanes); });
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
  kdtree::WalkCounters& walked_;
  kdtree::BuildCounters& built_;
  Content& content_;
};

}  // namespace sightline::accel::lazy
