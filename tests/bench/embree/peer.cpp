// Embree as a peer: scenes, builds and traces.
#include "tests/bench/embree/peer.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "tests/bench/embree/crossings.h"
#include "tests/bench/embree/device.h"
#include "tests/bench/embree/layout.h"
#include "tests/bench/embree/points.h"
#include "tests/bench/embree/rays.h"
#include "tests/bench/verbs/stopwatch.h"

namespace sightline::bench {
namespace {

using scenegraph::model::Affine;

class Peer final : public EmbreePeer {
 public:
  Peer(const SceneSource& scene, EmbreeSettings settings)
      : settings_(settings),
        frame_(embree_frame(scene)),
        meshes_(lay_out_for_embree(scene, frame_)) {}

  Status open(int threads) { return device_.open(threads); }

  Result<EmbreeBuilt> build() override;
  void choose_entry(std::span<const accel::geometry::Ray> rays, bool any) override;
  std::string entry() const override { return entry_.name(any_); }
  double trace(std::span<const accel::geometry::Ray> rays, bool any,
               std::span<accel::geometry::Hit> hits, std::size_t batch) override;
  EmbreeGrown grown() const override {
    return {nodes_.size(), triangles_, static_cast<std::uint64_t>(device_.bytes() - before_), 0};
  }
  void count(std::span<const accel::geometry::Ray> rays, std::span<std::uint32_t> counts) override {
    count_embree_crossings(scene_.get(), rays, frame_, counts);
  }
  double nearest(std::span<const accel::geometry::Vec3d> points,
                 std::span<accel::geometry::Hit> hits) override {
    return find_nearest_by_embree(scene_.get(), meshes_, frame_, points, hits);
  }

 private:
  EmbreeScenePtr new_scene() const;
  void attach_all();

  EmbreeSettings settings_;
  Affine frame_;  // Frame from world
  std::vector<EmbreeMesh> meshes_;
  EmbreeDevice device_;
  std::vector<EmbreeScenePtr> objects_;  // The scenes that instances refer to
  EmbreeScenePtr scene_;
  std::vector<std::uint64_t> nodes_;  // By Embree's number of a geometry or instance
  std::uint64_t triangles_ = 0;       // In all geometries; instances counted once
  std::int64_t before_ = 0;           // Bytes of the device without a scene
  EmbreeEntry entry_;
  bool any_ = false;
};

EmbreeScenePtr Peer::new_scene() const {
  EmbreeScenePtr scene(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene.get(), to_embree(settings_.quality));
  int flags = RTC_SCENE_FLAG_NONE;
  if (settings_.robust) flags |= RTC_SCENE_FLAG_ROBUST;
  if (settings_.crossings) flags |= RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
  rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(flags));
  return scene;
}

void Peer::attach_all() {
  scene_ = new_scene();
  nodes_.clear();
  triangles_ = 0;
  for (const EmbreeMesh& mesh : meshes_) {
    if (mesh.uses.empty() || mesh.faces.empty()) continue;
    triangles_ += mesh.triangles;
    const EmbreeGeometryPtr triangles =
        new_embree_triangles(device_.get(), settings_.quality, mesh.vertices, mesh.faces);
    if (!mesh.instanced()) {
      rtcAttachGeometryByID(scene_.get(), triangles.get(), static_cast<unsigned>(nodes_.size()));
      nodes_.push_back(mesh.uses.front().node);
      continue;
    }
    objects_.push_back(new_scene());
    rtcAttachGeometry(objects_.back().get(), triangles.get());
    for (const EmbreeMesh::Use& use : mesh.uses) {
      const EmbreeGeometryPtr instance(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
      rtcSetGeometryInstancedScene(instance.get(), objects_.back().get());
      std::array<float, 12> rows;
      std::transform(use.frame_from_local.m.begin(), use.frame_from_local.m.end(), rows.begin(),
                     [](double x) { return static_cast<float>(x); });
      rtcSetGeometryTransform(instance.get(), 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows.data());
      rtcCommitGeometry(instance.get());
      rtcAttachGeometryByID(scene_.get(), instance.get(), static_cast<unsigned>(nodes_.size()));
      nodes_.push_back(use.node);
    }
  }
}

Result<EmbreeBuilt> Peer::build() {
  scene_.reset();
  objects_.clear();
  before_ = device_.bytes();
  device_.begin_peak();
  EmbreeBuilt built;
  const Stopwatch total;
  attach_all();
  const Stopwatch commit;
  // Commits of small scenes use few threads, so scenes are committed in parallel.
  tbb::parallel_for(std::size_t{0}, objects_.size(),
                    [&](std::size_t i) { rtcCommitScene(objects_[i].get()); });
  rtcCommitScene(scene_.get());
  built.commit_seconds = commit.seconds();
  built.total_seconds = total.seconds();
  built.bytes_final = static_cast<std::uint64_t>(device_.bytes() - before_);
  built.bytes_peak = static_cast<std::uint64_t>(device_.bytes_peak() - before_);
  if (auto complaint = device_.status(); !complaint.ok()) return complaint.error();
  return built;
}

void Peer::choose_entry(std::span<const accel::geometry::Ray> rays, bool any) {
  any_ = any;
  entry_ = settings_.single ? EmbreeEntry{}
                            : fastest_entry(scene_.get(), rays, frame_, any, !objects_.empty());
}

double Peer::trace(std::span<const accel::geometry::Ray> rays, bool any,
                   std::span<accel::geometry::Hit> hits, std::size_t batch) {
  return trace_embree({scene_.get(), entry_, frame_, nodes_, false}, rays, any, hits, batch);
}

}  // namespace

bool embree_found() { return true; }

Result<std::unique_ptr<EmbreePeer>> EmbreePeer::make(const SceneSource& scene,
                                                     EmbreeSettings settings, int threads) {
  auto peer = std::make_unique<Peer>(scene, settings);
  if (auto opened = peer->open(threads); !opened.ok()) return opened.error();
  return std::unique_ptr<EmbreePeer>(std::move(peer));
}

}  // namespace sightline::bench
