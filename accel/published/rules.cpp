// Adapters: the papers' kd-tree builders behind SplitSearch, their hierarchies behind WholeTree.
#include "accel/published/any_builder.h"
#include "accel/published/bvh/bvh_tree.h"

namespace sightline::accel::published {
namespace {

/// The adapter of a builder whose value has choose().
template <class Builder>
class Search : public split::SplitSearch {
 public:
  explicit Search(const Builder& builder) : builder_(builder) {}

  std::optional<kdtree::Split> choose(const kdtree::CellRefs& cell,
                                      kdtree::BuildCounters& counters) const override {
    return builder_.choose(cell, counters);
  }

 protected:
  const Builder& builder() const { return builder_; }

 private:
  Builder builder_;
};

class HuntSearch final : public Search<kd::HuntScan> {
 public:
  using Search::Search;

  bool clips(std::size_t, std::size_t) const override { return builder().clip; }
  bool runs_passes() const override { return true; }
  bool scans_children(std::size_t references) const override {
    return builder().scans_children(references);
  }
  split::ChildPlanes child_planes(const geometry::Aabb& child) const override {
    return split::child_planes(child, builder().uniform_samples);
  }
};

template <class Builder>
class MedianSearch final : public Search<Builder> {
 public:
  using Search<Builder>::Search;

  int depth_bound(std::size_t references) const override {
    return this->builder().depth_bound(references);
  }
};

class ExactSearchRule final : public Search<kd::ExactBuilder> {
 public:
  using Search::Search;

  bool clips(std::size_t, std::size_t) const override { return builder().clips(); }
  bool takes_runs() const override { return false; }
};

class MinMaxSearch final : public Search<kd::MinMaxBuilder> {
 public:
  using Search::Search;

};

split::SplitRule make(const split::ScanSplit& b) { return split::make_rule(b); }
split::SplitRule make(const kd::HuntScan& b) { return std::make_shared<const HuntSearch>(b); }
split::SplitRule make(const kd::SpatialMedianBuilder& b) {
  return std::make_shared<const MedianSearch<kd::SpatialMedianBuilder>>(b);
}
split::SplitRule make(const kd::ObjectMedianBuilder& b) {
  return std::make_shared<const MedianSearch<kd::ObjectMedianBuilder>>(b);
}
split::SplitRule make(const kd::ExactBuilder& b) {
  return std::make_shared<const ExactSearchRule>(b);
}
split::SplitRule make(const kd::MinMaxBuilder& b) {
  return std::make_shared<const MinMaxSearch>(b);
}

class BvhMaker final : public mesh::WholeTreeMaker {
 public:
  explicit BvhMaker(const bvh::BvhBuilder& builder) : builder_(builder) {}
  std::unique_ptr<mesh::WholeTree> make(const geometry::MeshView& mesh) const override {
    return std::make_unique<bvh::BvhTree>(mesh, builder_);
  }

 private:
  bvh::BvhBuilder builder_;
};

}  // namespace

split::SplitRule rule_of(const KdBuilder& builder) {
  return std::visit([](const auto& b) { return make(b); }, builder);
}

AnyBuilder::operator mesh::TreeBuilder() const {
  if (const auto* hierarchy = std::get_if<bvh::BvhBuilder>(this))
    return {.whole = std::make_shared<const BvhMaker>(*hierarchy)};
  return {.rule = rule_of(std::get<KdBuilder>(*this))};
}

}  // namespace sightline::accel::published
