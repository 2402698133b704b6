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

bool LabelFilter::sees(const revision::Snapshot& snapshot, model::NodeId node) const {
  bool is_chosen = only_.empty();
  for (model::NodeId id = node; id != 0;) {
    const model::Node& above = *snapshot.find(id);
    if (has_match(excluded_, above.labels)) return false;
    is_chosen = is_chosen || has_match(only_, above.labels);
    id = above.parent;
  }
  return is_chosen;
}

}  // namespace sightline::scenegraph::query
