// Writes leaves and nodes, and joins what tasks have written.
#include "accel/published/kd/plain_writer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sightline::accel::published::kd {
namespace {

/// Capacity of a tree without a budget: pairs and ids for each reference, and a few more.
constexpr std::size_t kPairsEach = 32, kIdsEach = 64, kSpare = 64;

std::int64_t at_most(std::size_t count, std::uint64_t most) {
  return static_cast<std::int64_t>(std::min<std::uint64_t>(count, most));
}

}  // namespace

/// A budget bounds what leaves hold, and with it the number of nodes. The spare capacity is for
/// small subtrees, which have no budget.
PlainCapacity::PlainCapacity(double budget, std::size_t references) {
  const auto most = static_cast<std::size_t>(std::ceil(budget));
  const std::size_t pairs = most > 0 ? most : kPairsEach,
                    ids = most > 0 ? most + most / 2 : kIdsEach;
  pairs_ = at_most(references * pairs + kSpare, PlainNode::kMostPairs);
  ids_ = at_most(references * ids + kSpare, std::uint64_t{1} << 32);
}

std::uint32_t PlainWriter::begin_pair() {
  cells_.pairs.emplace_back();
  return static_cast<std::uint32_t>(cells_.pairs.size() - 1);
}

PlainNode PlainWriter::leaf(std::span<const kdtree::Reference> refs) {
  return leaf(refs, [&] { return failed_leaf(refs); });
}

PlainNode PlainWriter::long_leaf(std::span<const kdtree::Reference> refs) {
  const std::size_t first = cells_.ids.size();
  for (const kdtree::Reference& ref : refs) cells_.ids.push_back(ref.id);
  return PlainNode::leaf(refs.size(), first);
}

PlainNode PlainWriter::failed_leaf(std::span<const kdtree::Reference> refs) {
  const std::size_t first = cells_.failed.size();
  cells_.failed.insert(cells_.failed.end(), refs.begin(), refs.end());
  return PlainNode::failed_leaf(refs.size(), first);
}

PlainNode PlainWriter::append(const PlainWriter& other, PlainNode node) {
  const PlainCells& more = other.cells_;
  const std::size_t pairs = cells_.pairs.size(), ids = cells_.ids.size(),
                    failed = cells_.failed.size();
  const auto moved = [&](PlainNode at) {
    if (!at.is_leaf()) {
      return PlainNode::inner({static_cast<int>(at.axis()), at.position()},
                              at.pair() + static_cast<std::uint32_t>(pairs));
    }
    if (at.is_failed()) return PlainNode::failed_leaf(at.count(), at.first() + failed);
    return at.count() > 1 ? PlainNode::leaf(at.count(), at.first() + ids) : at;
  };
  for (const auto& [left, right] : more.pairs) cells_.pairs.push_back({moved(left), moved(right)});
  cells_.ids.insert(cells_.ids.end(), more.ids.begin(), more.ids.end());
  cells_.failed.insert(cells_.failed.end(), more.failed.begin(), more.failed.end());
  return moved(node);
}

PlainCells PlainWriter::finish(PlainNode root) {
  cells_.root = root;
  cells_.pairs.shrink_to_fit();
  cells_.ids.shrink_to_fit();
  cells_.failed.shrink_to_fit();
  return std::exchange(cells_, {});
}

}  // namespace sightline::accel::published::kd
