// Works in waves: all new nodes are examined in parallel, then the best of the open nodes are
// split.
#include "accel/published/bvh/best_first_growth.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

namespace sightline::accel::published::bvh {
namespace {

/// Number of nodes split before their children are compared with the others. Larger values give
/// fewer, longer waves. It is part of the method, because it decides which nodes are split last.
constexpr std::size_t kAtOnce = 32;

/// Memory that the lists of several nodes may share.
using Storage = std::shared_ptr<Fragment[]>;

enum class State : std::uint8_t { kNew, kOpen, kClosed, kDivided, kGrown };

struct PlanNode {
  PlanNode() = default;
  PlanNode(const CenterLists& l, Storage s, int d) : lists(l), storage(std::move(s)), depth(d) {}

  CenterLists lists;
  Storage storage;  ///< Memory of the lists; null for the root.
  int depth = 0;
  State state = State::kNew;
  ObjectSplit object;
  PlaneSplit plane;      ///< kOpen: the spatial split to make.
  std::size_t left = 0;  ///< kDivided: index of the first child; the second follows it.
  BvhChild grown;        ///< kGrown: the finished subtree.

  std::size_t added() const { return plane.added(lists.size()); }
  /// Saved cost per added reference.
  double merit() const {
    return (object.sum - plane.sum()) / static_cast<double>(std::max<std::size_t>(added(), 1));
  }
};

struct Children {
  PlanNode left, right;
};

/// Scratch buffers of tasks. A task keeps its buffers while other tasks run on its thread.
class ScratchPool {
 public:
  std::unique_ptr<SplitScratch> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<SplitScratch>();
    std::unique_ptr<SplitScratch> scratch = std::move(free_.back());
    free_.pop_back();
    return scratch;
  }
  void put_back(std::unique_ptr<SplitScratch> scratch) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(scratch));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<SplitScratch>> free_;
};

class BestFirstGrowth {
 public:
  BestFirstGrowth(const SplitSearch& search, const BvhLeafRule& leaf, std::size_t budget,
                  BvhGrowth& growth)
      : search_(search),
        leaf_(leaf),
        growth_(growth),
        closed_(search, leaf, growth, nullptr),
        unspent_(budget) {}

  BvhChild grow(const CenterLists& root, kdtree::BuildCounters& counters) {
    nodes_.emplace_back(root, nullptr, 0);
    std::vector<std::size_t> wave{0};
    while (!wave.empty()) {
      wave = advance(wave, counters);
      if (wave.empty()) wave = pay_for_best();
    }
    return assemble(0);
  }

 private:
  /// Advances these nodes by one step, in parallel. Returns the indices of the new children.
  std::vector<std::size_t> advance(const std::vector<std::size_t>& wave,
                                   kdtree::BuildCounters& counters) {
    std::vector<std::unique_ptr<Children>> made(wave.size());
    std::vector<kdtree::BuildCounters> counted(wave.size());
    tbb::parallel_for(std::size_t{0}, wave.size(), [&](std::size_t i) {
      std::unique_ptr<SplitScratch> scratch = scratches_.take();
      made[i] = step(nodes_[wave[i]], *scratch, counted[i]);
      scratches_.put_back(std::move(scratch));
    });
    std::vector<std::size_t> next;
    for (std::size_t i = 0; i < wave.size(); ++i) {
      counters += counted[i];
      if (nodes_[wave[i]].state == State::kOpen) offer(wave[i]);
      if (!made[i]) continue;
      nodes_[wave[i]].left = nodes_.size();
      next.insert(next.end(), {nodes_.size(), nodes_.size() + 1});
      nodes_.push_back(std::move(made[i]->left));
      nodes_.push_back(std::move(made[i]->right));
    }
    return next;
  }

  std::unique_ptr<Children> step(PlanNode& node, SplitScratch& scratch,
                                 kdtree::BuildCounters& counters) const {
    if (node.state == State::kOpen) return divide(node, true, scratch, counters);
    if (is_leaf_unasked(node.lists.size(), leaf_) || node.state == State::kClosed ||
        !search_.may_split_spatially(node.lists, node.depth)) {
      node.grown = closed_.grow(node.lists, node.depth, scratch, counters);
      return drop(node, State::kGrown);
    }
    node.object = search_.between(node.lists, node.depth, scratch, counters);
    const PlaneSplit* const plane =
        search_.by_plane(node.lists, node.depth, node.object, scratch, counters);
    const double sum = plane != nullptr ? plane->sum() : node.object.sum;
    if (leaf_.keeps(node.lists.size(), half_area(node.lists.box), sum)) {
      node.grown = closed_.leaf(node.lists);
      return drop(node, State::kGrown);
    }
    if (plane == nullptr) return divide(node, false, scratch, counters);
    node.plane = *plane;
    node.state = State::kOpen;
    return nullptr;
  }

  std::unique_ptr<Children> divide(PlanNode& node, bool by_plane, SplitScratch& scratch,
                                   kdtree::BuildCounters& counters) const {
    Storage storage = node.storage;
    ListHalves halves;
    if (by_plane) {
      storage = Storage(new Fragment[3 * node.plane.right]);
      halves = divide_by_plane(node.lists, node.plane, storage.get(), counters);
    } else {
      halves = divide_by_centers(node.lists, node.object.axis, node.object.left, scratch.lists,
                                 counters);
    }
    auto children = std::make_unique<Children>();
    children->left = PlanNode(halves.left, node.storage, node.depth + 1);
    children->right = PlanNode(halves.right, std::move(storage), node.depth + 1);
    drop(node, State::kDivided);
    return children;
  }

  /// Frees what a node no longer needs.
  static std::unique_ptr<Children> drop(PlanNode& node, State state) {
    node.state = state;
    node.storage = nullptr;
    node.plane = {};
    return nullptr;
  }

  struct Offer {
    double merit;
    std::size_t node;
    bool operator<(const Offer& o) const {
      return merit != o.merit ? merit < o.merit : node > o.node;
    }
  };
  void offer(std::size_t node) {
    offers_.push_back({nodes_[node].merit(), node});
    std::push_heap(offers_.begin(), offers_.end());
  }

  /// Returns the next wave: the best open nodes. A node whose split exceeds the remaining budget is
  /// closed.
  std::vector<std::size_t> pay_for_best() {
    std::vector<std::size_t> wave;
    while (!offers_.empty() && wave.size() < kAtOnce) {
      std::pop_heap(offers_.begin(), offers_.end());
      const std::size_t at = offers_.back().node;
      offers_.pop_back();
      PlanNode& node = nodes_[at];
      const std::size_t added = node.added();
      if (added <= unspent_) {
        unspent_ -= added;
      } else {
        node.state = State::kClosed;
      }
      wave.push_back(at);
    }
    return wave;
  }

  BvhChild assemble(std::size_t at) {
    const PlanNode& node = nodes_[at];
    if (node.state == State::kGrown) return node.grown;
    const BvhChild left = assemble(node.left);
    return growth_.inner(left, assemble(node.left + 1));
  }

  const SplitSearch& search_;
  const BvhLeafRule& leaf_;
  BvhGrowth& growth_;
  ListGrowth closed_;
  std::size_t unspent_;  ///< Rest of the budget, in references.
  std::vector<PlanNode> nodes_;
  std::vector<Offer> offers_;  ///< Heap of the open nodes.
  ScratchPool scratches_;
};

}  // namespace

BvhChild grow_best_first(const SplitSearch& search, const BvhLeafRule& leaf,
                         const CenterLists& root, std::size_t budget, BvhGrowth& growth,
                         kdtree::BuildCounters& counters) {
  return BestFirstGrowth(search, leaf, budget, growth).grow(root, counters);
}

}  // namespace sightline::accel::published::bvh
