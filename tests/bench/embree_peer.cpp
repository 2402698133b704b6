// Embree's side of the comparison: device, scenes, and what is timed.
#include "tests/bench/embree_peer.h"

#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <numeric>

#include "tests/bench/embree_crossings.h"
#include "tests/bench/embree_rays.h"
#include "tests/bench/stopwatch.h"

namespace sightline::bench {
namespace {

using accel::Vec3d;
using accel::Vec3f;
using scenegraph::Affine;

template <auto kRelease>
struct Release {
  template <class T>
  void operator()(T* object) const {
    kRelease(object);
  }
};
using DevicePtr = std::unique_ptr<RTCDeviceTy, Release<rtcReleaseDevice>>;
using ScenePtr = std::unique_ptr<RTCSceneTy, Release<rtcReleaseScene>>;
using GeometryPtr = std::unique_ptr<RTCGeometryTy, Release<rtcReleaseGeometry>>;

// What Embree holds of memory, as it tells its monitor.
struct Memory {
  std::atomic<std::int64_t> now = 0, peak = 0;

  static bool monitor(void* self, std::ptrdiff_t bytes, bool) {
    auto& memory = *static_cast<Memory*>(self);
    const std::int64_t now = memory.now += bytes;
    std::int64_t peak = memory.peak;
    while (now > peak && !memory.peak.compare_exchange_weak(peak, now)) {
    }
    return true;
  }
};

// The first complaint of the device, from whichever thread.
struct Complaint {
  std::mutex mutex;
  std::string first;

  static void report(void* self, RTCError code, const char* text) {
    auto& complaint = *static_cast<Complaint*>(self);
    const std::lock_guard lock(complaint.mutex);
    if (complaint.first.empty()) {
      complaint.first =
          "Embree: error " + std::to_string(static_cast<int>(code)) + ": " + (text ? text : "");
    }
  }
  Status status() {
    const std::lock_guard lock(mutex);
    if (first.empty()) return {};
    return Error{Code::kInternal, first, "EMBREE"};
  }
};

// A mesh as Embree is given it, and the nodes that carry it.
struct EmbreeMesh {
  std::vector<Vec3f> vertices;  // the last one is padding
  std::vector<accel::Face> faces;
  struct Use {
    std::uint64_t node;
    Affine frame_from_local;
  };
  std::vector<Use> uses;
  bool instanced() const { return uses.size() > 1; }
};

RTCBuildQuality build_quality(EmbreeQuality quality) {
  switch (quality) {
    case EmbreeQuality::kLow:
      return RTC_BUILD_QUALITY_LOW;
    case EmbreeQuality::kMedium:
      return RTC_BUILD_QUALITY_MEDIUM;
    case EmbreeQuality::kHigh:
      break;
  }
  return RTC_BUILD_QUALITY_HIGH;
}

// Turns with the first node, does not move with it.
Affine frame_of(const SceneSource& scene) {
  if (scene.nodes.empty()) return {};
  Affine turn = scene.nodes.front().parent_from_local;
  turn.m[3] = turn.m[7] = turn.m[11] = 0;
  return scenegraph::inverse(turn).value_or(Affine{});
}

std::vector<EmbreeMesh> lay_out(const SceneSource& scene, const Affine& frame) {
  std::vector<EmbreeMesh> meshes(scene.meshes.size());
  std::vector<Affine> placed;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const SourceNode& node = scene.nodes[n];
    placed.push_back(compose(node.parent ? placed[*node.parent] : frame, node.parent_from_local));
    if (node.mesh) meshes[*node.mesh].uses.push_back({node_id(n), placed.back()});
  }
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    EmbreeMesh& mesh = meshes[m];
    mesh.faces = scene.meshes[m].faces;
    mesh.vertices.reserve(scene.meshes[m].vertices.size() + 1);
    mesh.vertices = scene.meshes[m].vertices;
    mesh.vertices.push_back({});
    if (mesh.uses.size() != 1 || mesh.uses.front().frame_from_local == Affine{}) continue;
    for (Vec3f& v : mesh.vertices) v = Vec3f(mesh.uses.front().frame_from_local.point(Vec3d(v)));
  }
  return meshes;
}

class Peer final : public EmbreePeer {
 public:
  Peer(const SceneSource& scene, EmbreeSettings settings)
      : settings_(settings), frame_(frame_of(scene)), meshes_(lay_out(scene, frame_)) {}

  Status open(int threads) {
    device_.reset(rtcNewDevice(("threads=" + std::to_string(threads)).c_str()));
    if (!device_) return Error{Code::kInternal, "Embree: no device", "EMBREE"};
    rtcSetDeviceErrorFunction(device_.get(), &Complaint::report, &complaint_);
    rtcSetDeviceMemoryMonitorFunction(device_.get(), &Memory::monitor, &memory_);
    return {};
  }

  Result<EmbreeBuilt> build() override;
  void choose_entry(std::span<const accel::Ray> rays, bool any) override;
  std::string entry() const override { return entry_.name(any_); }
  double trace(std::span<const accel::Ray> rays, bool any, std::span<accel::Hit> hits,
               std::size_t batch) override;
  void count(std::span<const accel::Ray> rays, std::span<std::uint32_t> counts) override {
    count_embree_crossings(scene_.get(), rays, frame_, counts);
  }

 private:
  ScenePtr new_scene() const;
  GeometryPtr new_triangles(const EmbreeMesh& mesh) const;
  void attach_all();

  EmbreeSettings settings_;
  Affine frame_;  // from the world
  std::vector<EmbreeMesh> meshes_;
  Memory memory_;
  Complaint complaint_;
  DevicePtr device_;
  std::vector<ScenePtr> objects_;  // what instances stand for
  ScenePtr scene_;
  std::vector<std::uint64_t> nodes_;  // by Embree's number of a geometry or instance
  EmbreeEntry entry_;
  bool any_ = false;
};

ScenePtr Peer::new_scene() const {
  ScenePtr scene(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene.get(), build_quality(settings_.quality));
  int flags = RTC_SCENE_FLAG_NONE;
  if (settings_.robust) flags |= RTC_SCENE_FLAG_ROBUST;
  if (settings_.crossings) flags |= RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
  rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(flags));
  return scene;
}

GeometryPtr Peer::new_triangles(const EmbreeMesh& mesh) const {
  GeometryPtr geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetGeometryBuildQuality(geometry.get(), build_quality(settings_.quality));
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             mesh.vertices.data(), 0, sizeof(Vec3f), mesh.vertices.size() - 1);
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.faces.data(), 0, sizeof(accel::Face), mesh.faces.size());
  rtcCommitGeometry(geometry.get());
  return geometry;
}

void Peer::attach_all() {
  scene_ = new_scene();
  nodes_.clear();
  for (const EmbreeMesh& mesh : meshes_) {
    if (mesh.uses.empty() || mesh.faces.empty()) continue;
    const GeometryPtr triangles = new_triangles(mesh);
    if (!mesh.instanced()) {
      rtcAttachGeometryByID(scene_.get(), triangles.get(), static_cast<unsigned>(nodes_.size()));
      nodes_.push_back(mesh.uses.front().node);
      continue;
    }
    objects_.push_back(new_scene());
    rtcAttachGeometry(objects_.back().get(), triangles.get());
    for (const EmbreeMesh::Use& use : mesh.uses) {
      const GeometryPtr instance(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
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
  const std::int64_t before = memory_.now;
  memory_.peak = before;
  EmbreeBuilt built;
  const Stopwatch total;
  attach_all();
  const Stopwatch commit;
  // Commits of small scenes do not use many threads, but scenes can be committed at once.
  tbb::parallel_for(std::size_t{0}, objects_.size(),
                    [&](std::size_t i) { rtcCommitScene(objects_[i].get()); });
  rtcCommitScene(scene_.get());
  built.commit_seconds = commit.seconds();
  built.total_seconds = total.seconds();
  built.bytes_final = static_cast<std::uint64_t>(memory_.now - before);
  built.bytes_peak = static_cast<std::uint64_t>(memory_.peak - before);
  if (auto complaint = complaint_.status(); !complaint.ok()) return complaint.error();
  return built;
}

void Peer::choose_entry(std::span<const accel::Ray> rays, bool any) {
  any_ = any;
  // Whole blocks, so that coherent rays stay so, from everywhere in the batch.
  constexpr std::size_t kTrialRays = 65'536, kTrials = 3;
  std::vector<accel::Ray> trial;
  const std::size_t step = std::max<std::size_t>(rays.size() / kTrialRays, 1) * kEmbreeBlock;
  for (std::size_t first = 0; first < rays.size(); first += step) {
    const auto block = rays.subspan(first, std::min(kEmbreeBlock, rays.size() - first));
    trial.insert(trial.end(), block.begin(), block.end());
  }
  if (trial.empty()) return;
  double best = std::numeric_limits<double>::infinity();
  for (const EmbreeEntry& entry : kEmbreeEntries) {
    // Embree 3.13.5 never returns from some coherent occlusion packets under instances.
    if (any && entry.coherent && !objects_.empty()) continue;
    EmbreeRays buffer(entry, any);
    for (std::size_t repeat = 0; repeat < kTrials; ++repeat) {
      buffer.fill(trial, frame_);
      const Stopwatch clock;
      buffer.trace(scene_.get(), 0, trial.size());
      const double seconds = clock.seconds();
      if (seconds >= best) continue;
      best = seconds;
      entry_ = entry;
    }
  }
}

double Peer::trace(std::span<const accel::Ray> rays, bool any, std::span<accel::Hit> hits,
                   std::size_t batch) {
  if (rays.empty()) return 0;
  if (batch == 0) batch = rays.size();
  EmbreeRays buffer(entry_, any);
  double seconds = 0;
  for (std::size_t first = 0; first < rays.size(); first += batch) {
    const std::size_t count = std::min(batch, rays.size() - first);
    buffer.fill(rays.subspan(first, count), frame_);
    const Stopwatch clock;
    buffer.trace(scene_.get(), 0, count);
    seconds += clock.seconds();
    for (std::size_t i = 0; i < count; ++i) {
      const EmbreeRays::Answer answer = buffer.answer(i);
      accel::Hit& hit = hits[first + i];
      hit = {};
      if (!answer.hit) continue;
      hit.state = accel::HitState::kHit;
      if (any) continue;
      hit.t = static_cast<double>(answer.t);
      hit.primitive = answer.primitive;
      hit.node =
          nodes_[answer.instance == RTC_INVALID_GEOMETRY_ID ? answer.geometry : answer.instance];
    }
  }
  return seconds;
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
