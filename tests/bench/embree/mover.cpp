// A moving part under Embree: layouts, and what a frame costs.
#include "tests/bench/embree/mover.h"

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

// Triangles where they are to be, with the padding that Embree reads.
struct Laid {
  std::vector<Vec3f> vertices;
  const std::vector<accel::geometry::Face>* faces = nullptr;
  std::uint64_t node = 0;

  void lay(const std::vector<Vec3f>& from, const Affine& place) {
    vertices.resize(from.size() + 1);
    std::transform(from.begin(), from.end(), vertices.begin(),
                   [&](const Vec3f& v) { return Vec3f(place.point(Vec3d(v))); });
  }
};

class Mover final : public EmbreeMover {
 public:
  Mover(const StagedScene& scene, const Motion& motion, EmbreeUpdate update)
      : scene_(scene), motion_(motion), update_(update) {
    lay_still();
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
  void lay_still();
  Status build(Layout layout);
  EmbreeScenePtr new_scene(RTCBuildQuality quality, RTCSceneFlags flags) const;
  void attach(RTCScene scene, const Laid& laid, RTCBuildQuality quality, std::size_t id,
              std::vector<EmbreeGeometryPtr>* keep);
  EmbreeGeometryPtr attach_instance(RTCScene of, const Affine& place);
  void build_parts();
  void place(RTCGeometry instance, const Affine& where) const;

  const StagedScene& scene_;
  const Motion& motion_;
  EmbreeUpdate update_;
  Affine frame_;  // the world's own
  std::vector<Laid> still_, moving_;
  std::vector<std::uint64_t> nodes_;  // by geometry, whatever scene it is in
  EmbreeDevice device_;
  Layout layout_ = Layout::kOneScene;
  EmbreeScenePtr still_scene_, moving_scene_;
  std::vector<EmbreeScenePtr> part_scenes_;
  EmbreeScenePtr top_;
  std::vector<EmbreeGeometryPtr> changing_;  // geometries or instances, one a moving node
  EmbreeEntry entry_, any_entry_;
};

void Mover::lay_still() {
  std::vector<Affine> placed;
  const SceneSource& source = scene_.source;
  for (std::size_t n = 0; n < source.nodes.size(); ++n) {
    const SourceNode& node = source.nodes[n];
    placed.push_back(node.parent ? compose(placed[*node.parent], node.parent_from_local)
                                 : node.parent_from_local);
    if (!node.mesh) continue;
    const SourceMesh& mesh = source.meshes[*node.mesh];
    Laid& laid = (n < scene_.still ? still_ : moving_).emplace_back();
    laid.lay(mesh.vertices, placed.back());
    laid.faces = &mesh.faces;
    laid.node = node_id(n);
  }
  for (const auto* part : {&still_, &moving_}) {
    for (const Laid& laid : *part) nodes_.push_back(laid.node);
  }
}

EmbreeScenePtr Mover::new_scene(RTCBuildQuality quality, RTCSceneFlags flags) const {
  EmbreeScenePtr scene(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene.get(), quality);
  rtcSetSceneFlags(scene.get(), flags);
  return scene;
}

void Mover::attach(RTCScene scene, const Laid& laid, RTCBuildQuality quality, std::size_t id,
                   std::vector<EmbreeGeometryPtr>* keep) {
  EmbreeGeometryPtr geometry =
      new_embree_triangles(device_.get(), EmbreeQuality::kMedium, laid.vertices, *laid.faces);
  rtcSetGeometryBuildQuality(geometry.get(), quality);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene, geometry.get(), static_cast<unsigned>(id));
  if (keep != nullptr) keep->push_back(std::move(geometry));
}

void Mover::place(RTCGeometry instance, const Affine& where) const {
  std::array<float, 12> rows;
  std::transform(where.m.begin(), where.m.end(), rows.begin(),
                 [](double x) { return static_cast<float>(x); });
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows.data());
}

EmbreeGeometryPtr Mover::attach_instance(RTCScene of, const Affine& where) {
  EmbreeGeometryPtr instance(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(instance.get(), of);
  place(instance.get(), where);
  rtcCommitGeometry(instance.get());
  rtcAttachGeometry(top_.get(), instance.get());
  return instance;
}

// Each part's own scene is built once, in the part's frame.
void Mover::build_parts() {
  for (std::size_t n = 0; n < moving_.size(); ++n) {
    moving_[n].lay(motion_.vertices(n, 0), Affine{});
    part_scenes_.push_back(new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE));
    attach(part_scenes_.back().get(), moving_[n], RTC_BUILD_QUALITY_HIGH, still_.size() + n,
           nullptr);
    rtcCommitScene(part_scenes_.back().get());
    changing_.push_back(attach_instance(part_scenes_.back().get(), motion_.place(n, 0)));
  }
}

Status Mover::build(Layout layout) {
  layout_ = layout;
  changing_.clear();
  top_.reset();
  part_scenes_.clear();
  moving_scene_.reset();
  still_scene_.reset();
  // LOW as a scene's quality stands for two levels: what does not change keeps its tree.
  top_ = new_scene(RTC_BUILD_QUALITY_LOW, RTC_SCENE_FLAG_DYNAMIC);
  const RTCBuildQuality quality =
      update_ == EmbreeUpdate::kRefit ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_LOW;
  RTCScene holds_still = top_.get(), holds_moving = top_.get();
  if (layout != Layout::kOneScene) {
    still_scene_ = new_scene(RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE);
    holds_still = still_scene_.get();
  }
  for (std::size_t i = 0; i < still_.size(); ++i) {
    attach(holds_still, still_[i],
           layout == Layout::kOneScene ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH, i,
           nullptr);
  }
  if (still_scene_ && !still_.empty()) {
    rtcCommitScene(still_scene_.get());
    attach_instance(still_scene_.get(), Affine{});
  }
  if (layout == Layout::kInstances) {
    build_parts();
  } else {
    if (layout == Layout::kTwoScenes) {
      moving_scene_ = new_scene(RTC_BUILD_QUALITY_LOW, RTC_SCENE_FLAG_DYNAMIC);
      holds_moving = moving_scene_.get();
    }
    for (std::size_t n = 0; n < moving_.size(); ++n) {
      moving_[n].lay(motion_.vertices(n, 0), motion_.place(n, 0));
      attach(holds_moving, moving_[n], quality, still_.size() + n, &changing_);
    }
    if (moving_scene_) {
      rtcCommitScene(moving_scene_.get());
      attach_instance(moving_scene_.get(), Affine{});
    }
  }
  rtcCommitScene(top_.get());
  return device_.status();
}

Result<EmbreeMover::Advanced> Mover::advance(std::size_t frame) {
  Advanced advanced;
  const Stopwatch update;
  tbb::parallel_for(std::size_t{0}, moving_.size(), [&](std::size_t n) {
    if (layout_ == Layout::kInstances) {
      place(changing_[n].get(), motion_.place(n, frame));
    } else {
      moving_[n].lay(motion_.vertices(n, frame), motion_.place(n, frame));
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
    rtcCommitGeometry(rtcGetGeometry(top_.get(), still_.empty() ? 0 : 1));
  }
  rtcCommitScene(top_.get());
  advanced.build_seconds = build.seconds();
  if (Status fine = device_.status(); !fine.ok()) return fine.error();
  return advanced;
}

Status Mover::choose(std::span<const accel::geometry::Ray> rays) {
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
      // The first is a warm-up.
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

std::string Mover::layout() const {
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

Result<std::unique_ptr<EmbreeMover>> EmbreeMover::make(const StagedScene& scene,
                                                       const Motion& motion, EmbreeUpdate update,
                                                       int threads) {
  auto mover = std::make_unique<Mover>(scene, motion, update);
  if (auto opened = mover->open(threads); !opened.ok()) return opened.error();
  return std::unique_ptr<EmbreeMover>(std::move(mover));
}

}  // namespace sightline::bench
