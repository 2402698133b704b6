// Updates partial sums from the changed children up.
#include "scenegraph/hierarchy/summary_tree.h"

namespace sightline::scenegraph::hierarchy {
namespace {

using Steps = model::PersistentMap<std::shared_ptr<const NodeSummary>>;

NodeSummary value(const Steps& steps, std::uint64_t key) {
  const std::shared_ptr<const NodeSummary>* step = steps.find(key);
  return step == nullptr ? NodeSummary{} : **step;
}

bool is_nothing(const NodeSummary& sum) { return sum.height == 0; }

/// Returns a partial sum of which only the parts `changed` have changed. `known` is its former
/// value, or null.
NodeSummary step(const NodeSummary* known, std::uint64_t key,
                 std::span<const std::uint64_t> changed, const SummaryTree::Parts& parts) {
  if (known != nullptr) {
    NodeSummary sum = *known;
    bool exact = true;
    for (const std::uint64_t id : changed)
      exact = exact && try_replace(sum, parts.before(id), parts.after(id));
    if (exact) return sum;
  }
  NodeSummary sum;
  for (std::uint64_t id = key * SummaryTree::kFan; id < (key + 1) * SummaryTree::kFan; ++id)
    add(sum, parts.after(id));
  return sum;
}

/// Updates one level; returns the keys of the partial sums that it has updated.
std::vector<std::uint64_t> update_level(Steps& steps, std::span<const std::uint64_t> changed,
                                        const SummaryTree::Parts& parts) {
  std::vector<std::uint64_t> keys;
  Steps::Edit edit(steps);
  while (!changed.empty()) {
    const std::uint64_t key = changed.front() / SummaryTree::kFan;
    std::size_t count = 0;
    while (count < changed.size() && changed[count] / SummaryTree::kFan == key) ++count;
    const std::shared_ptr<const NodeSummary>* known = steps.find(key);
    const NodeSummary sum =
        step(known == nullptr ? nullptr : known->get(), key, changed.first(count), parts);
    edit.set(key, is_nothing(sum) ? nullptr : std::make_shared<const NodeSummary>(sum));
    keys.push_back(key);
    changed = changed.subspan(count);
  }
  return keys;
}

}  // namespace

void SummaryTree::update(std::span<const model::NodeId> changed, const Parts& parts) {
  std::vector<std::uint64_t> keys(changed.begin(), changed.end());
  Parts of_level = parts;
  for (std::size_t level = 0; !keys.empty(); ++level) {
    if (level == levels_.size()) {
      // The topmost level is one step, that of key 0, and stays so while no key is larger.
      if (level > 0 && keys.back() == 0) return;
      levels_.emplace_back();
      // the step that was topmost
      if (level > 0 && keys.front() != 0) keys.insert(keys.begin(), 0);
    }
    const Steps before = levels_[level];
    keys = update_level(levels_[level], keys, of_level);
    const Steps after = levels_[level];
    of_level.before = [before](std::uint64_t key) { return value(before, key); };
    of_level.after = [after](std::uint64_t key) { return value(after, key); };
  }
}

NodeSummary SummaryTree::total() const {
  return levels_.empty() ? NodeSummary{} : value(levels_.back(), 0);
}

NodeSummary SummaryTree::total_with(std::span<const model::NodeId> changed,
                                    const Parts& parts) const {
  SummaryTree other = *this;
  other.update(changed, parts);
  return other.total();
}

}  // namespace sightline::scenegraph::hierarchy
