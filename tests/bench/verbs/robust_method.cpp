// Ways to find hits.
#include "tests/bench/verbs/robust_method.h"
#include "accel/published/any_builder.h"

#include "scenegraph/trace.h"
#include "tests/bench/embree/peer.h"
#include "tests/bench/verbs/kernel_walk.h"
#include "tests/bench/verbs/stopwatch.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using accel::published::AnyBuilder;
using SnapshotPtr = std::shared_ptr<const scenegraph::revision::Snapshot>;

Result<SnapshotPtr> built(const SceneSource& scene, const AnyBuilder& builder) {
  auto snapshot = assemble(scene, builder);
  if (!snapshot.ok()) return snapshot.error();
  if (const auto all = scenegraph::build_all(**snapshot); !all.ok()) return all.error();
  return snapshot;
}

class Exact : public RobustMethod {
 public:
  Exact(SnapshotPtr snapshot, std::string builder)
      : snapshot_(std::move(snapshot)), builder_(std::move(builder)) {}

  std::string name() const override { return "exact"; }
  bool exact() const override { return true; }
  std::string builder() const override { return builder_; }

  Result<double> trace(std::span<const Ray> rays, std::span<Hit> hits) override {
    const Stopwatch clock;
    const auto traced = scenegraph::trace(*snapshot_, rays, hits, {.surface = false});
    const double seconds = clock.seconds();
    if (!traced.ok()) return traced.error();
    return seconds;
  }

  Status count(std::span<const Ray> rays, std::span<std::uint32_t> counts) override {
    std::vector<scenegraph::RayTally> tallies(rays.size());
    const auto counted =
        scenegraph::count_hits(*snapshot_, rays, tallies, {.kind = scenegraph::QueryKind::kCount});
    if (!counted.ok()) return counted.error();
    for (std::size_t i = 0; i < rays.size(); ++i) counts[i] = tallies[i].count;
    return {};
  }

 protected:
  void replace(SnapshotPtr snapshot) { snapshot_ = std::move(snapshot); }

 private:
  SnapshotPtr snapshot_;
  std::string builder_;
};

class ExactLazy final : public Exact {
 public:
  ExactLazy(const SceneSource& scene, const AnyBuilder& builder, std::string builder_name)
      : Exact(nullptr, std::move(builder_name)), scene_(scene), made_by_(builder) {}

  bool grows() const override { return true; }

  Result<double> trace(std::span<const Ray> rays, std::span<Hit> hits) override {
    if (auto fresh = begin(); !fresh.ok()) return fresh.error();
    return Exact::trace(rays, hits);
  }

  Status count(std::span<const Ray> rays, std::span<std::uint32_t> counts) override {
    if (auto fresh = begin(); !fresh.ok()) return fresh.error();
    return Exact::count(rays, counts);
  }

 private:
  Status begin() {
    auto snapshot = assemble(scene_, made_by_);
    if (!snapshot.ok()) return snapshot.error();
    replace(*std::move(snapshot));
    return {};
  }

  const SceneSource& scene_;
  AnyBuilder made_by_;
};

// The ray with all numbers rounded to float, as in a program without doubles.
std::vector<Ray> in_float(std::span<const Ray> rays) {
  std::vector<Ray> rounded(rays.begin(), rays.end());
  for (Ray& ray : rounded) {
    ray.origin = Vec3d(Vec3f(ray.origin));
    ray.direction = Vec3d(Vec3f(ray.direction));
  }
  return rounded;
}

class Plain final : public RobustMethod {
 public:
  Plain(SnapshotPtr snapshot, std::string builder)
      : snapshot_(std::move(snapshot)), builder_(std::move(builder)) {}

  std::string name() const override { return "plain-float"; }
  std::string builder() const override { return builder_; }

  Result<double> trace(std::span<const Ray> rays, std::span<Hit> hits) override {
    const std::vector<Ray> rounded = in_float(rays);
    const Stopwatch clock;
    trace_closest(snapshot_->trees().static_tree(), TriangleTest::kPlainFloat, rounded, hits);
    return clock.seconds();
  }

  Status count(std::span<const Ray> rays, std::span<std::uint32_t> counts) override {
    count_crossings(snapshot_->trees().static_tree(), TriangleTest::kPlainFloat, in_float(rays),
                    counts);
    return {};
  }

 private:
  SnapshotPtr snapshot_;
  std::string builder_;
};

class Embree final : public RobustMethod {
 public:
  Embree(std::unique_ptr<EmbreePeer> fast, std::unique_ptr<EmbreePeer> filtered, bool robust)
      : fast_(std::move(fast)), filtered_(std::move(filtered)), robust_(robust) {}

  std::string name() const override { return robust_ ? "embree-robust" : "embree"; }
  std::string builder() const override {
    return robust_ ? "embree-medium-robust" : "embree-medium";
  }

  void tune(std::span<const Ray> rays) override { fast_->choose_entry(rays, false); }

  Result<double> trace(std::span<const Ray> rays, std::span<Hit> hits) override {
    return fast_->trace(rays, false, hits, 0);
  }

  Status count(std::span<const Ray> rays, std::span<std::uint32_t> counts) override {
    filtered_->count(rays, counts);
    return {};
  }

 private:
  std::unique_ptr<EmbreePeer> fast_, filtered_;
  bool robust_;
};

}  // namespace

SceneSource in_float_world(const SceneSource& scene) {
  SceneSource flat;
  std::vector<scenegraph::model::Affine> world_from_local;
  for (const SourceNode& node : scene.nodes) {
    world_from_local.push_back(node.parent
                                   ? compose(world_from_local[*node.parent], node.parent_from_local)
                                   : node.parent_from_local);
    std::optional<std::size_t> mesh;
    if (node.mesh) {
      SourceMesh moved = scene.meshes[*node.mesh];
      for (Vec3f& v : moved.vertices) v = Vec3f(world_from_local.back().point(Vec3d(v)));
      mesh = flat.add_mesh(std::move(moved));
    }
    flat.add_node(std::nullopt, node.name, {}, mesh);
  }
  return flat;
}

Result<std::unique_ptr<RobustMethod>> make_exact_full(const SceneSource& scene,
                                                      const std::string& builder_name,
                                                      const AnyBuilder& builder) {
  auto snapshot = built(scene, builder);
  if (!snapshot.ok()) return snapshot.error();
  return std::unique_ptr<RobustMethod>(std::make_unique<Exact>(*std::move(snapshot), builder_name));
}

std::unique_ptr<RobustMethod> make_exact_lazy(const SceneSource& scene,
                                              const std::string& builder_name,
                                              const AnyBuilder& builder) {
  return std::make_unique<ExactLazy>(scene, builder, builder_name);
}

Result<std::unique_ptr<RobustMethod>> make_plain_float(const SceneSource& scene,
                                                       const std::string& builder_name,
                                                       const AnyBuilder& builder) {
  auto snapshot = built(in_float_world(scene), builder);
  if (!snapshot.ok()) return snapshot.error();
  return std::unique_ptr<RobustMethod>(std::make_unique<Plain>(*std::move(snapshot), builder_name));
}

Result<std::unique_ptr<RobustMethod>> make_embree(const SceneSource& scene, bool robust,
                                                  int threads) {
  std::array<std::unique_ptr<EmbreePeer>, 2> peers;
  for (const bool filtered : {false, true}) {
    EmbreeSettings settings{EmbreeQuality::kMedium, robust};
    settings.crossings = filtered;
    auto peer = EmbreePeer::make(scene, settings, threads);
    if (!peer.ok()) return peer.error();
    if (auto done = (*peer)->build(); !done.ok()) return done.error();
    peers[filtered ? 1 : 0] = *std::move(peer);
  }
  return std::unique_ptr<RobustMethod>(
      std::make_unique<Embree>(std::move(peers[0]), std::move(peers[1]), robust));
}

}  // namespace sightline::bench
