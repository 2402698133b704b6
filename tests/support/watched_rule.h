// The product's split rule, with a look at every cell that it is asked about.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "accel/split/scan_split.h"
#include "accel/split/split_search.h"

namespace sightline::tests {

/// Calls look(cell) before it chooses, from any thread. Otherwise as the default rule.
class WatchedRule final : public accel::split::SplitSearch {
 public:
  using Look = std::function<void(const accel::kdtree::CellRefs&)>;
  explicit WatchedRule(Look look) : look_(std::move(look)) {}

  std::optional<accel::kdtree::Split> choose(
      const accel::kdtree::CellRefs& cell, accel::kdtree::BuildCounters& counters) const override {
    look_(cell);
    return rule_->choose(cell, counters);
  }
  bool clips(std::size_t straddlers, std::size_t references) const override {
    return rule_->clips(straddlers, references);
  }
  bool runs_passes() const override { return rule_->runs_passes(); }
  bool takes_samples() const override { return rule_->takes_samples(); }
  bool scans_children(std::size_t references) const override {
    return rule_->scans_children(references);
  }
  accel::split::ChildPlanes child_planes(const accel::geometry::Aabb& child) const override {
    return rule_->child_planes(child);
  }
  double budget(bool in_blocks) const override { return rule_->budget(in_blocks); }

 private:
  const accel::split::SplitRule& rule_ = accel::split::default_rule();
  const Look look_;
};

}  // namespace sightline::tests
