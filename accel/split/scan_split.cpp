// The product's rule: exhaustive search for short lists, a guided scan for the others.
#include "accel/split/scan_split.h"

#include "accel/split/guided_scan.h"
#include "accel/split/out_of_range.h"

namespace sightline::accel::split {
namespace {

/// With `clip_dense` straddlers are clipped in lists, and in slices of lists, of at least kClipFrom
/// references, if one in kStraddleShare straddles.
constexpr std::size_t kClipFrom = 32, kStraddleShare = 4;

/// Lists up to this length are always searched exhaustively: that is cheaper than a scan.
constexpr std::size_t kExactAnyway = 12;

class ScanSearch final : public SplitSearch {
 public:
  explicit ScanSearch(const ScanSplit& rule) : rule_(rule) {}

  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const override {
    return rule_.choose(cell, counters);
  }
  bool clips(std::size_t straddlers, std::size_t references) const override {
    return rule_.clips(straddlers, references);
  }
  bool runs_passes() const override { return true; }
  bool takes_samples() const override { return !rule_.clip; }
  /// False for short lists, most of whose children are searched exhaustively, and with clipping,
  /// which changes the counted boxes.
  bool scans_children(std::size_t references) const override {
    return !rule_.clip && references >= 2 * std::size_t{rule_.exact_below};
  }
  ChildPlanes child_planes(const geometry::Aabb& child) const override {
    return split::child_planes(child, rule_.uniform_samples);
  }
  double budget(bool in_blocks) const override {
    const bool is_usual = rule_.budget == kUsualBudget;
    if (in_blocks) return is_usual || rule_.budget == 0 ? kBlockBudget : rule_.budget;
    return is_usual ? kPlainBudget : rule_.budget;
  }

 private:
  ScanSplit rule_;
};

}  // namespace

std::optional<std::string> ScanSplit::check() const {
  const auto most = static_cast<std::uint32_t>(kdtree::kUniformPlanes);
  if (auto e = out_of_range("uniform_samples", uniform_samples, 2u, most)) return e;
  if (auto e = out_of_range("exact_below", exact_below, 0u, std::uint32_t{kMaxBoundScan})) return e;
  if (budget != 0 && budget != kUsualBudget) {
    if (auto e = out_of_range("budget", budget, 1.0, 64.0)) return e;
  }
  if (auto e = out_of_range("cost_traverse", cost.traverse, 0.0, 1e6)) return e;
  if (auto e = out_of_range("cost_intersect", cost.intersect, 1e-6, 1e6)) return e;
  if (auto e = out_of_range("empty_bonus", cost.empty_bonus, 1e-6, 1.0)) return e;
  return out_of_range("retry_above", retry_above, 1e-6, std::numeric_limits<double>::infinity());
}

bool ScanSplit::clips(std::size_t straddlers, std::size_t references) const {
  if (clip) return true;
  return clip_dense && references >= kClipFrom && straddlers * kStraddleShare >= references;
}

bool is_over_duplicated(const kdtree::CellPath& path, std::size_t references) {
  constexpr double kLeastDuplication = 2, kMost = 256;
  const double growth = path.duplication - 1;
  return path.duplication >= kLeastDuplication &&
         growth * growth * static_cast<double>(references) >= kMost;
}

std::optional<BoundRule> ScanSplit::bound_rule(std::size_t references) const {
  if (references > exact_below) return std::nullopt;
  return BoundRule{.cost = cost, .all_axes_up_to = all_axes_up_to, .retry_above = retry_above};
}

std::optional<kdtree::Split> ScanSplit::choose(const kdtree::CellRefs& list,
                                               kdtree::BuildCounters& counters) const {
  if (list.size == 0) return std::nullopt;
  const bool over_duplicated = list.size > kExactAnyway && is_over_duplicated(list.path, list.size);
  if (const auto rule = bound_rule(list.size); rule && !over_duplicated)
    return choose_bound(list.refs, list.box, *rule, counters);
  return choose_guided(list,
                       {.cost = cost,
                        .uniform_samples = uniform_samples,
                        .refine_all_axes = refine_all_axes,
                        .once = over_duplicated},
                       counters);
}

ScanSplit scan_fast() {
  constexpr double kPoorCut = 0.85;  // a split above this share of a leaf's cost is poor
  return {.retry_above = kPoorCut, .clip_dense = true};
}

ScanSplit scan_best() {
  ScanSplit best;
  best.all_axes_up_to = best.exact_below;
  best.clip = true;
  return best;
}

SplitRule make_rule(const ScanSplit& rule) { return std::make_shared<const ScanSearch>(rule); }

const SplitRule& default_rule() {
  static const SplitRule kRule = make_rule(scan_fast());
  return kRule;
}

}  // namespace sightline::accel::split
