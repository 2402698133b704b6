// Merges several batches of transforms and patches.
#include "server/updates/coalesce.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

namespace sightline::server::updates {
namespace {

using scenegraph::model::Affine;
using scenegraph::model::NodeRef;
using scenegraph::model::PatchVertices;
using scenegraph::model::SetTransforms;
using scenegraph::model::Update;

bool are_ids(const std::vector<NodeRef>& nodes) {
  return std::ranges::all_of(nodes, [](NodeRef node) { return node > 0; });
}

/// Whether the update is valid in any scene. Scene::apply does not see a transform that a newer one
/// replaces.
bool is_sound(const Update& update) {
  if (const auto* set = std::get_if<SetTransforms>(&update)) {
    return are_ids(set->nodes) &&
           std::ranges::all_of(set->parent_from_local,
                               [](const Affine& matrix) { return is_finite(matrix); });
  }
  const auto* patch = std::get_if<PatchVertices>(&update);
  return patch != nullptr && are_ids(patch->nodes);
}

bool may_coalesce(const UpdateBatch& batch) {
  return !batch.bad && std::ranges::all_of(batch.updates, is_sound);
}

SetTransforms newest_transforms(const std::deque<UpdateBatch>& batches, std::size_t count) {
  SetTransforms newest;
  std::unordered_map<NodeRef, std::size_t> rows;
  for (std::size_t i = 0; i < count; ++i) {
    for (const Update& update : batches[i].updates) {
      const auto* set = std::get_if<SetTransforms>(&update);
      if (set == nullptr) continue;
      for (std::size_t k = 0; k < set->nodes.size(); ++k) {
        const auto [row, is_new] = rows.emplace(set->nodes[k], newest.nodes.size());
        if (is_new) {
          newest.nodes.push_back(set->nodes[k]);
          newest.parent_from_local.push_back(set->parent_from_local[k]);
        } else {
          newest.parent_from_local[row->second] = set->parent_from_local[k];
        }
      }
    }
  }
  return newest;
}

/// The most ranges of one set of nodes. More would cost more than they save.
constexpr std::size_t kRangesRemembered = 16;

/// Add patches from the newest to the oldest: add() returns whether a newer patch covers this one.
class Covered {
 public:
  bool add(const PatchVertices& patch) {
    auto& ranges = by_nodes_[{patch.nodes.begin(), patch.nodes.end()}];
    const Range range{patch.first, std::uint64_t{patch.first} + patch.positions.size()};
    const bool covered = std::ranges::any_of(ranges, [&](const Range& newer) {
      return newer.first <= range.first && range.second <= newer.second;
    });
    if (!covered && ranges.size() < kRangesRemembered) ranges.push_back(range);
    return covered;
  }

 private:
  using Range = std::pair<std::uint64_t, std::uint64_t>;
  std::map<std::set<NodeRef>, std::vector<Range>> by_nodes_;
};

void append_newest_patches(const std::deque<UpdateBatch>& batches, std::size_t count,
                           std::vector<Update>& out) {
  Covered covered;
  std::vector<const PatchVertices*> kept;
  for (std::size_t i = count; i-- > 0;) {
    const auto& updates = batches[i].updates;
    for (auto update = updates.rbegin(); update != updates.rend(); ++update) {
      const auto* patch = std::get_if<PatchVertices>(&*update);
      if (patch != nullptr && !covered.add(*patch)) kept.push_back(patch);
    }
  }
  for (auto patch = kept.rbegin(); patch != kept.rend(); ++patch) out.emplace_back(**patch);
}

}  // namespace

std::size_t count_to_coalesce(const std::deque<UpdateBatch>& batches) {
  const auto end = std::ranges::find_if_not(batches, may_coalesce);
  return static_cast<std::size_t>(end - batches.begin());
}

std::vector<Update> coalesce(const std::deque<UpdateBatch>& batches, std::size_t count) {
  std::vector<Update> updates;
  SetTransforms transforms = newest_transforms(batches, count);
  if (!transforms.nodes.empty()) updates.emplace_back(std::move(transforms));
  append_newest_patches(batches, count, updates);
  return updates;
}

}  // namespace sightline::server::updates
