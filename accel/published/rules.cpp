// Adapters: the papers' kd-tree builders behind SplitSearch, and all trees behind WholeTree.
#include "accel/published/any_builder.h"
#include "accel/published/bvh/bvh_tree.h"
#include "accel/published/kd/plain_tree.h"

namespace sightline::accel::published {
namespace {

/// The adapter of a builder whose value has choose() and clips().
template <class Builder>
class Search : public split::SplitSearch {
 public:
  explicit Search(const Builder& builder) : builder_(builder) {}

  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const override {
    return builder_.choose(cell, counters);
  }
  bool clips(std::size_t, std::size_t) const override { return builder_.clips(); }

 protected:
  const Builder& builder() const { return builder_; }

 private:
  Builder builder_;
};

class HuntSearch final : public Search<kd::HuntScan> {
 public:
  using Search::Search;

  bool runs_passes() const override { return true; }
  bool scans_children(std::size_t references) const override {
    return builder().scans_children(references);
  }
  split::ChildPlanes child_planes(const geometry::Aabb& child) const override {
    return split::child_planes(child, builder().uniform_samples);
  }
};

template <class Builder>
split::SplitRule search_by(const Builder& builder) {
  return std::make_shared<const Search<Builder>>(builder);
}

/// The rule for small lists; nothing for builders that clip.
template <class Builder>
std::optional<split::BoundRule> small_rule(const Builder& builder, bool clips) {
  return clips ? std::nullopt : builder.bound_rule(kd::kSmallList);
}

kd::PlainRule make(const ScanBuilder& b) {
  return {.search = split::make_rule(b), .small = small_rule(b, b.clip)};
}
kd::PlainRule make(const kd::HuntScan& b) {
  return {.search = std::make_shared<const HuntSearch>(b), .small = small_rule(b, b.clip)};
}
kd::PlainRule make(const kd::SpatialMedianBuilder& b) {
  return {.search = search_by(b), .stop = b.stop};
}
kd::PlainRule make(const kd::ObjectMedianBuilder& b) {
  return {.search = search_by(b), .stop = b.stop};
}
kd::PlainRule make(const kd::ExactBuilder& b) {
  kd::PlainRule rule{.search = search_by(b)};
  if (b.search == kd::ExactSearch::kSweep) rule.events = b;
  return rule;
}
kd::PlainRule make(const kd::MinMaxBuilder& b) {
  return {.search = search_by(b), .small = small_rule(b, false)};
}

class BvhMaker final : public mesh::WholeTreeMaker {
 public:
  explicit BvhMaker(const bvh::BvhBuilder& builder) : builder_(builder) {}
  std::unique_ptr<mesh::WholeTree> make(const geometry::MeshView& mesh,
                                        const mesh::MeshStats&) const override {
    return std::make_unique<bvh::BvhTree>(mesh, builder_);
  }

 private:
  bvh::BvhBuilder builder_;
};

class PlainTreeMaker final : public mesh::WholeTreeMaker {
 public:
  explicit PlainTreeMaker(const kd::PlainRule& rule) : rule_(rule) {}
  std::unique_ptr<mesh::WholeTree> make(const geometry::MeshView& mesh,
                                        const mesh::MeshStats& stats) const override {
    return std::make_unique<kd::PlainTree>(mesh, stats, rule_);
  }

 private:
  kd::PlainRule rule_;
};

}  // namespace

kd::PlainRule plain_rule(const KdBuilder& builder) {
  return std::visit([](const auto& b) { return make(b); }, builder);
}

AnyBuilder::operator mesh::TreeBuilder() const {
  if (const auto* hierarchy = std::get_if<bvh::BvhBuilder>(this))
    return {.whole = std::make_shared<const BvhMaker>(*hierarchy)};
  const auto& builder = std::get<KdBuilder>(*this);
  if (const auto* ours = std::get_if<ScanBuilder>(&builder); ours != nullptr && ours->blocks)
    return {.rule = split::make_rule(*ours)};
  return {.whole = std::make_shared<const PlainTreeMaker>(plain_rule(builder))};
}

}  // namespace sightline::accel::published
