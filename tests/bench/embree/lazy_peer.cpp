// Embree's own laziness: objects are built when the first ray reaches them.
#include <tbb/parallel_for.h>

#include <deque>
#include <limits>
#include <tuple>
#include <utility>

#include "tests/bench/embree/lazy_objects.h"
#include "tests/bench/embree/peer.h"
#include "tests/bench/embree/rays.h"
#include "tests/bench/verbs/stopwatch.h"

namespace sightline::bench {
namespace {

using scenegraph::model::Affine;

constexpr EmbreeQuality kQualities[] = {EmbreeQuality::kLow, EmbreeQuality::kMedium};

std::string name(EmbreeQuality quality) {
  return quality == EmbreeQuality::kLow ? "LOW" : "MEDIUM";
}

class LazyPeer final : public EmbreePeer {
 public:
  explicit LazyPeer(const SceneSource& scene)
      : frame_(embree_frame(scene)), meshes_(lay_out_for_embree(scene, frame_)) {
    for (const EmbreeMesh& mesh : meshes_) {
      for (const EmbreeMesh::Use& use : mesh.uses) nodes_.push_back(use.node);
    }
  }

  Status open(int threads) { return device_.open(threads); }

  Result<EmbreeBuilt> build() override;
  void choose_entry(std::span<const accel::geometry::Ray> rays, bool any) override;
  std::string entry() const override {
    return EmbreeEntry{}.name(any_) + ", objects " + name(inner_) + " in " + name(outer_);
  }
  double trace(std::span<const accel::geometry::Ray> rays, bool any,
               std::span<accel::geometry::Hit> hits, std::size_t batch) override {
    return trace_embree({scene_.get(), EmbreeEntry{}, frame_, nodes_}, rays, any, hits, batch);
  }
  EmbreeGrown grown() const override;
  void count(std::span<const accel::geometry::Ray>, std::span<std::uint32_t> counts) override {
    std::fill(counts.begin(), counts.end(), 0u);
  }
  double nearest(std::span<const accel::geometry::Vec3d>,
                 std::span<accel::geometry::Hit>) override {
    return 0;
  }

 private:
  void attach_all();

  Affine frame_;  // Frame from world
  std::vector<EmbreeMesh> meshes_;
  std::vector<std::uint64_t> nodes_;  // By object number
  EmbreeQuality inner_ = EmbreeQuality::kLow, outer_ = EmbreeQuality::kLow;
  EmbreeDevice device_;
  std::deque<EmbreeLazyMesh> lazy_;
  std::vector<EmbreeLazyObject> objects_;
  EmbreeScenePtr scene_;
  std::int64_t before_ = 0;  // Bytes of the device without a scene
  bool any_ = false;
};

// All of this is timed, in particular the bounds of all objects.
void LazyPeer::attach_all() {
  objects_.resize(nodes_.size());
  std::vector<const EmbreeMesh::Use*> uses;
  for (const EmbreeMesh& mesh : meshes_) {
    if (mesh.uses.empty()) continue;
    EmbreeLazyMesh& lazy = lazy_.emplace_back(mesh, device_.get(), inner_);
    for (const EmbreeMesh::Use& use : mesh.uses) {
      EmbreeLazyObject& object = objects_[uses.size()];
      object = {};
      object.mesh = &lazy;
      object.number = static_cast<unsigned>(uses.size());
      // A mesh of only one node is already in the frame.
      object.moved = mesh.instanced();
      uses.push_back(&use);
    }
  }
  tbb::parallel_for(std::size_t{0}, objects_.size(), [&](std::size_t i) {
    EmbreeLazyObject& object = objects_[i];
    object.bounds = embree_bounds(object.mesh->mesh(), *uses[i], object.moved);
    if (!object.moved) return;
    const Affine back = scenegraph::model::inverse(uses[i]->frame_from_local).value_or(Affine{});
    std::transform(back.m.begin(), back.m.end(), object.local_from_frame.begin(),
                   [](double x) { return static_cast<float>(x); });
  });
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene_.get(), to_embree(outer_));
  for (EmbreeLazyObject& object : objects_) {
    if (object.mesh->mesh().faces.empty()) continue;
    const EmbreeGeometryPtr geometry = new_embree_lazy_geometry(device_.get(), object);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometryByID(scene_.get(), geometry.get(), object.number);
  }
}

Result<EmbreeBuilt> LazyPeer::build() {
  scene_.reset();
  objects_.clear();
  lazy_.clear();
  before_ = device_.bytes();
  device_.begin_peak();
  EmbreeBuilt built;
  const Stopwatch total;
  attach_all();
  const Stopwatch commit;
  rtcCommitScene(scene_.get());
  built.commit_seconds = commit.seconds();
  built.total_seconds = total.seconds();
  built.bytes_final = static_cast<std::uint64_t>(device_.bytes() - before_);
  built.bytes_peak = static_cast<std::uint64_t>(device_.bytes_peak() - before_);
  if (auto complaint = device_.status(); !complaint.ok()) return complaint.error();
  return built;
}

// Leaves a fresh build behind.
void LazyPeer::choose_entry(std::span<const accel::geometry::Ray> rays, bool any) {
  any_ = any;
  constexpr int kTrials = 3;
  std::vector<accel::geometry::Hit> hits(rays.size());
  double best = std::numeric_limits<double>::infinity();
  std::pair<EmbreeQuality, EmbreeQuality> chosen{inner_, outer_};
  const auto attempt = [&](EmbreeQuality inner, EmbreeQuality outer) {
    inner_ = inner;
    outer_ = outer;
    const auto built = build();
    if (!built.ok()) return;
    const double seconds = built->total_seconds + trace(rays, any, hits, 0);
    if (seconds >= best) return;
    best = seconds;
    chosen = {inner, outer};
  };
  for (int trial = 0; trial < kTrials; ++trial) {
    for (const EmbreeQuality inner : kQualities) {
      for (const EmbreeQuality outer : kQualities) attempt(inner, outer);
    }
  }
  std::tie(inner_, outer_) = chosen;
  (void)build();
}

EmbreeGrown LazyPeer::grown() const {
  EmbreeGrown grown;
  std::uint64_t nanoseconds = 0;
  for (const EmbreeLazyMesh& mesh : lazy_) {
    if (!mesh.built()) continue;
    ++grown.objects;
    grown.triangles += mesh.mesh().triangles;
    nanoseconds += mesh.nanoseconds();
  }
  grown.bytes = static_cast<std::uint64_t>(device_.bytes() - before_);
  grown.seconds_in_trace = static_cast<double>(nanoseconds) * 1e-9;
  return grown;
}

}  // namespace

Result<std::unique_ptr<EmbreePeer>> EmbreePeer::make_lazy(const SceneSource& scene, int threads) {
  auto peer = std::make_unique<LazyPeer>(scene);
  if (auto opened = peer->open(threads); !opened.ok()) return opened.error();
  return std::unique_ptr<EmbreePeer>(std::move(peer));
}

}  // namespace sightline::bench
