// Looks for each label of a node among the matches, which are sorted.
#include "scenegraph/query/label_filter.h"

#include <algorithm>
#include <utility>

namespace sightline::scenegraph::query {
namespace {

/// Sorts by keys, and among equal keys puts the match of any value first.
bool precedes(const LabelMatch& a, const LabelMatch& b) {
  return a.key != b.key ? a.key < b.key : a.value < b.value;
}

bool matches(const std::vector<LabelMatch>& sorted, const model::Label& label) {
  const auto of_key = std::ranges::equal_range(sorted, label.key, {}, &LabelMatch::key);
  if (of_key.empty()) return false;
  return !of_key.front().value ||
         std::ranges::binary_search(
             of_key, label.value, {},
             [](const LabelMatch& match) -> const std::string& { return *match.value; });
}

bool has_match(const std::vector<LabelMatch>& sorted, const model::Labels& labels) {
  return labels != nullptr && std::ranges::any_of(*labels, [&](const model::Label& label) {
           return matches(sorted, label);
         });
}

}  // namespace

LabelFilter::LabelFilter(std::vector<LabelMatch> only, std::vector<LabelMatch> excluded)
    : only_(std::move(only)), excluded_(std::move(excluded)) {
  std::ranges::sort(only_, precedes);
  std::ranges::sort(excluded_, precedes);
}

LabelView::State LabelView::state_of(model::NodeId node) const {
  const model::Node& found = *snapshot_->find(node);
  const State inherited = above(found.parent);
  if (inherited == State::kExcluded || has_match(filter_.excluded_, found.labels))
    return State::kExcluded;
  const bool is_chosen = inherited == State::kSeen || has_match(filter_.only_, found.labels);
  return is_chosen ? State::kSeen : State::kNotChosen;
}

LabelView::State LabelView::above(model::NodeId node) const {
  if (node == 0) return filter_.only_.empty() ? State::kSeen : State::kNotChosen;
  if (const auto known = above_.find(node); known != above_.end()) return known->second;
  const State state = state_of(node);
  above_.emplace(node, state);
  return state;
}

}  // namespace sightline::scenegraph::query
