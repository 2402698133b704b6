// A moving part under Embree: layouts, and what a frame costs.
#include "tests/bench/embree/dynamic_peer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "tests/bench/embree/device.h"
#include "tests/bench/embree/rays.h"
#include "tests/bench/verbs/stopwatch.h"

namespace sightline::bench {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;

enum class Layout : std::uint8_t { kOneScene, kTwoScenes, kInstances };

constexpr std::size_t kTrialFrames = 4;

// Transformed triangles, with the padding that Embree reads.
struct Laid {
  std::vector<Vec3f> vertices;
  const std::vector<accel::geometry::Face>* faces = nullptr;
  std::uint64_t node = 0;

  void lay(const std::vector<Vec3f>& from, const Affine& world_from_local) {
    vertices.resize(from.size() + 1);
    std::transform(from.begin(), from.end(), vertices.begin(),
                   [&](const Vec3f& v) { return Vec3f(world_from_local.point(Vec3d(v))); });
  }
};

class DynamicPeer final : public EmbreeDynamicPeer {
 public:
  DynamicPeer(const StagedScene& scene, const Motion& motion, EmbreeUpdate update)
      : scene_(scene), motion_(motion), update_(update) {
    lay_static();
  }

  Status open(int threads) { return device_.open(threads); }

  Status choose(std::span<const accel::geometry::Ray> rays) override;
  void choose_any(std::span<const accel::geometry::Ray> rays) override {
    any_entry_ = fastest_entry(top_.get(), rays, frame_, true, layout_ != Layout::kOneScene);
  }
  std::string layout() const override;
  std::string entry(bool any) const override { return (any ? any_entry_ : entry_).name(any); }
  Result<Advanced> advance(std::size_t frame) override;
  double trace(std::span<const accel::geometry::Ray> rays, bool any,
               std::span<accel::geometry::Hit> hits) override {
    return trace_embree({top_.get(), any ? any_entry_ : entry_, frame_, nodes_, true}, rays, any,
                        hits, 0);
  }

 private:
  void lay_static();
  Status build(Layout layout);
  EmbreeScenePtr new_scene(RTCBuildQuality quality, RTCSceneFlags flags) const;
  void attach(RTCScene scene, const Laid& laid, RTCBuildQuality quality, std::size_t id,
              std::vector<EmbreeGeometryPtr>* keep);
  EmbreeGeometryPtr attach_instance(RTCScene of, const Affine& where);
  void build_parts();
  void set_transform(RTCGeometry instance, const Affine& where) const;

  const StagedScene& scene_;
  const Motion& motion_;
  EmbreeUpdate update_;
  Affine frame_;  // Identity: all geometry is in world space
  std::vector<Laid> static_, moving_;
  std::vector<std::uint64_t> nodes_;  // By geometry, over all scenes
  EmbreeDevice device_;
  Layout layout_ = Layout::kOneScene;
  EmbreeScenePtr static_scene_, moving_scene_;
  std::vector<EmbreeScenePtr> part_scenes_;
  EmbreeScenePtr top_;
  std::vector<EmbreeGeometryPtr> changing_;  // One geometry or instance for each moving node
  EmbreeEntry entry_, any_entry_;
};

void DynamicPeer::lay_static() {
  std::vector<Affine> placed;
  const SceneSource& source = scene_.source;
  for (std::size_t n = 0; n < source.nodes.size(); ++n) {
    const SourceNode& node = source.nodes[n];
    placed.push_back(node.parent ? compose(placed[*node.parent], node.parent_from_local)
                                 : node.parent_from_local);
    if (!node.mesh) continue;
    const SourceMesh& mesh = source.meshes[*node.mesh];
    Laid& laid = (n < scene_.static_nodes ? static_ : moving_).emplace_back();
    laid.lay(mesh.vertices, placed.back());
    laid.faces = &mesh.faces;
    laid.node = node_id(n);
  }
  for (const auto* part : {&static_, &moving_}) {
    for (const Laid& laid : *part) nodes_.push_back(laid.node);
  }
}

EmbreeScenePtr DynamicPeer::new_scene(RTCBuildQuality quality, RTCSceneFlags flags) const {
  EmbreeScenePtr scene(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene.get(), quality);
  rtcSetSceneFlags(scene.get(), flags);
  return scene;
}

void DynamicPeer::attach(RTCScene scene, const Laid& laid, RTCBuildQuality quality, std::size_t id,
                         std::vector<EmbreeGeometryPtr>* keep) {
  EmbreeGeometryPtr geometry =
      new_embree_triangles(device_.get(), EmbreeQuality::kMedium, laid.vertices, *laid.faces);
  rtcSetGeometryBuildQuality(geometry.get(), quality);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene, geometry.get(), static_cast<unsigned>(id));
  if (keep != nullptr) keep->push_back(std::move(geometry));
}

void DynamicPeer::set_transform(RTCGeometry instance, const Affine& where) const {
  std::array<float, 12> rows;
  std::transform(where.m.begin(), where.m.end(), rows.begin(),
                 [](double x) { return static_cast<float>(x); });
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows.data());
}

EmbreeGeometryPtr DynamicPeer::attach_instance(RTCScene of, const Affine& where) {
  EmbreeGeometryPtr instance(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(instance.get(), of);
  set_transform(instance.get(), where);
  rtcCommitGeometry(instance.get());
  rtcAttachGeometry(top_.get(), instance.get());
  return instance;
}

// Builds each part's scene once, in the part's own frame.
void DynamicPeer::build_parts() {
  for (std::size_t n = 0; n < moving_.size(); ++n) {
    moving_[n].lay(motion_.vertices(n, 0), Affine{});
    part_scenes_.push_back(new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE));
    attach(part_scenes_.back().get(), moving_[n], RTC_BUILD_QUALITY_HIGH, static_.size() + n,
           nullptr);
    rtcCommitScene(part_scenes_.back().get());
    changing_.push_back(attach_instance(part_scenes_.back().get(), motion_.transform(n, 0)));
  }
}

Status DynamicPeer::build(Layout layout) {
  layout_ = layout;
  changing_.clear();
  top_.reset();
  part_scenes_.clear();
  moving_scene_.reset();
  static_scene_.reset();
  // LOW as a scene's quality stands for two levels: unchanged geometries keep their trees.
  top_ = new_scene(RTC_BUILD_QUALITY_LOW, RTC_SCENE_FLAG_DYNAMIC);
  const RTCBuildQuality quality =
      update_ == EmbreeUpdate::kRefit ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_LOW;
  RTCScene static_target = top_.get(), moving_target = top_.get();
  if (layout != Layout::kOneScene) {
    static_scene_ = new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
    static_target = static_scene_.get();
  }
  for (std::size_t i = 0; i < static_.size(); ++i) {
    attach(static_target, static_[i],
           layout == Layout::kOneScene ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH, i,
           nullptr);
  }
  if (static_scene_ && !static_.empty()) {
    rtcCommitScene(static_scene_.get());
    attach_instance(static_scene_.get(), Affine{});
  }
  if (layout == Layout::kInstances) {
    build_parts();
  } else {
    if (layout == Layout::kTwoScenes) {
      moving_scene_ = new_scene(RTC_BUILD_QUALITY_LOW, RTC_SCENE_FLAG_DYNAMIC);
      moving_target = moving_scene_.get();
    }
    for (std::size_t n = 0; n < moving_.size(); ++n) {
      moving_[n].lay(motion_.vertices(n, 0), motion_.transform(n, 0));
      attach(moving_target, moving_[n], quality, static_.size() + n, &changing_);
    }
    if (moving_scene_) {
      rtcCommitScene(moving_scene_.get());
      attach_instance(moving_scene_.get(), Affine{});
    }
  }
  rtcCommitScene(top_.get());
  return device_.status();
}

Result<EmbreeDynamicPeer::Advanced> DynamicPeer::advance(std::size_t frame) {
  Advanced advanced;
  const Stopwatch update;
  tbb::parallel_for(std::size_t{0}, moving_.size(), [&](std::size_t n) {
    if (layout_ == Layout::kInstances) {
      set_transform(changing_[n].get(), motion_.transform(n, frame));
    } else {
      moving_[n].lay(motion_.vertices(n, frame), motion_.transform(n, frame));
    }
  });
  advanced.update_seconds = update.seconds();
  const Stopwatch build;
  for (const EmbreeGeometryPtr& geometry : changing_) {
    if (layout_ != Layout::kInstances)
      rtcUpdateGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry.get());
  }
  if (moving_scene_) rtcCommitScene(moving_scene_.get());
  if (layout_ == Layout::kTwoScenes) {
    // The instance's bounds are those of the scene below.
    rtcCommitGeometry(rtcGetGeometry(top_.get(), static_.empty() ? 0 : 1));
  }
  rtcCommitScene(top_.get());
  advanced.build_seconds = build.seconds();
  if (Status fine = device_.status(); !fine.ok()) return fine.error();
  return advanced;
}

Status DynamicPeer::choose(std::span<const accel::geometry::Ray> rays) {
  std::vector<Layout> layouts{Layout::kOneScene, Layout::kTwoScenes};
  if (motion_.rigid() && update_ == EmbreeUpdate::kRebuild) layouts.push_back(Layout::kInstances);
  std::vector<accel::geometry::Hit> hits(rays.size());
  double best = std::numeric_limits<double>::infinity();
  Layout chosen = layouts.front();
  EmbreeEntry entry;
  for (const Layout layout : layouts) {
    if (Status built = build(layout); !built.ok()) return built;
    entry_ = fastest_entry(top_.get(), rays, frame_, false, layout != Layout::kOneScene);
    double seconds = 0;
    for (std::size_t frame = 1; frame <= kTrialFrames; ++frame) {
      const auto advanced = advance(frame);
      if (!advanced.ok()) return advanced.error();
      const double traced = trace(rays, false, hits);
      // The first run is a warm-up.
      if (frame > 1) seconds += advanced->update_seconds + advanced->build_seconds + traced;
    }
    if (seconds >= best) continue;
    best = seconds;
    chosen = layout;
    entry = entry_;
  }
  entry_ = entry;
  return build(chosen);
}

std::string DynamicPeer::layout() const {
  switch (layout_) {
    case Layout::kOneScene:
      return "one scene";
    case Layout::kTwoScenes:
      return "two scenes";
    case Layout::kInstances:
      break;
  }
  return "instances";
}

}  // namespace

Result<std::unique_ptr<EmbreeDynamicPeer>> EmbreeDynamicPeer::make(const StagedScene& scene,
                                                                   const Motion& motion,
                                                                   EmbreeUpdate update,
                                                                   int threads) {
  auto peer = std::make_unique<DynamicPeer>(scene, motion, update);
  if (auto opened = peer->open(threads); !opened.ok()) return opened.error();
  return std::unique_ptr<EmbreeDynamicPeer>(std::move(peer));
}

}  // namespace sightline::bench
