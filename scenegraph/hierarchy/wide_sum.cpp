// From the changed children up, step by step.
#include "scenegraph/hierarchy/wide_sum.h"

namespace sightline::scenegraph::hierarchy {
namespace {

using Steps = model::PersistentMap<std::shared_ptr<const Subtree>>;

Subtree value(const Steps& steps, std::uint64_t key) {
  const std::shared_ptr<const Subtree>* step = steps.find(key);
  return step == nullptr ? Subtree{} : **step;
}

bool is_nothing(const Subtree& sum) { return sum.mesh_nodes == 0 && sum.groups == 0; }

/// The step over `changed`, which are all its own; `known` is what it was.
Subtree step(const Subtree* known, std::uint64_t key, std::span<const std::uint64_t> changed,
             const WideSum::Parts& parts) {
  if (known != nullptr) {
    Subtree sum = *known;
    bool exact = true;
    for (const std::uint64_t id : changed)
      exact = exact && replace(sum, parts.before(id), parts.after(id));
    if (exact) return sum;
  }
  Subtree sum;
  for (std::uint64_t id = key * WideSum::kFan; id < (key + 1) * WideSum::kFan; ++id)
    include(sum, parts.after(id));
  return sum;
}

/// Brings one level up to date; returns the steps that are other than before.
std::vector<std::uint64_t> update_level(Steps& steps, std::span<const std::uint64_t> changed,
                                        const WideSum::Parts& parts) {
  std::vector<std::uint64_t> keys;
  Steps::Edit edit(steps);
  while (!changed.empty()) {
    const std::uint64_t key = changed.front() / WideSum::kFan;
    std::size_t count = 0;
    while (count < changed.size() && changed[count] / WideSum::kFan == key) ++count;
    const std::shared_ptr<const Subtree>* known = steps.find(key);
    const Subtree sum =
        step(known == nullptr ? nullptr : known->get(), key, changed.first(count), parts);
    edit.set(key, is_nothing(sum) ? nullptr : std::make_shared<const Subtree>(sum));
    keys.push_back(key);
    changed = changed.subspan(count);
  }
  return keys;
}

}  // namespace

void WideSum::update(std::span<const model::NodeId> changed, const Parts& parts) {
  std::vector<std::uint64_t> keys(changed.begin(), changed.end());
  Parts of_level = parts;
  for (std::size_t level = 0; !keys.empty(); ++level) {
    if (level == levels_.size()) {
      // The topmost level is one step, that of key 0, and stays so while no key is larger.
      if (level > 0 && keys.back() == 0) return;
      levels_.emplace_back();
      if (level > 0 && keys.front() != 0) keys.insert(keys.begin(), 0);  // what was topmost so far
    }
    const Steps before = levels_[level];
    keys = update_level(levels_[level], keys, of_level);
    const Steps after = levels_[level];
    of_level.before = [before](std::uint64_t key) { return value(before, key); };
    of_level.after = [after](std::uint64_t key) { return value(after, key); };
  }
}

Subtree WideSum::total() const { return levels_.empty() ? Subtree{} : value(levels_.back(), 0); }

Subtree WideSum::total_with(std::span<const model::NodeId> changed, const Parts& parts) const {
  WideSum other = *this;
  other.update(changed, parts);
  return other.total();
}

}  // namespace sightline::scenegraph::hierarchy
