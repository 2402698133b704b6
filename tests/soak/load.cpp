// The kinds of load of a soak.
#include "tests/soak/load.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"

namespace sightline::tests::soak {
namespace {

using Clock = std::chrono::steady_clock;

// The load is below what two busy cores can do, and the same at any time.
constexpr std::chrono::milliseconds kStreamEvery{500}, kCastEvery{25}, kSceneEvery{500};
constexpr std::uint64_t kBatchesPerCall = 100;
constexpr std::size_t kRaysPerBatch = 4096, kRaysJudged = 64;

/// Lets a load act at fixed times. One that is late leaves out the times that have passed.
class Pace {
 public:
  explicit Pace(Clock::duration period) : period_(period) {}
  void wait() {
    due_ = std::max(due_ + period_, Clock::now());
    std::this_thread::sleep_until(due_);
  }

 private:
  const Clock::duration period_;
  Clock::time_point due_ = Clock::now();
};

v1::CastRaysRequest rich_request(const std::string& scene,
                                 std::span<const accel::geometry::Ray> rays) {
  v1::CastRaysRequest request = cast_request(scene, rays);
  for (const v1::HitField field :
       {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_BARYCENTRIC,
        v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT})
    request.add_fields(field);
  return request;
}

/// Compares the first rays of the answer with brute force.
void judge(Progress& progress, std::span<const accel::geometry::Ray> rays,
           const v1::CastRaysResponse& reply, const BruteForce& oracle) {
  const std::vector<accel::geometry::Hit> hits = decode_hits(reply);
  ASSERT_EQ(hits.size(), rays.size());
  const std::size_t judged = std::min(rays.size(), kRaysJudged);
  const Comparison compared =
      compare(rays.first(judged), std::span(hits).first(judged), oracle, {.surface = true});
  EXPECT_TRUE(compared.clean()) << compared.report();
  progress.judged += judged;
}

/// Casts rays at a scene with one node, at node 1.
class FixedScene {
 public:
  FixedScene(Progress& progress, std::string name, TestMesh mesh)
      : progress_(progress),
        name_(std::move(name)),
        mesh_(std::move(mesh)),
        oracle_({{.mesh = {mesh_.vertices, mesh_.faces}, .node = 1}}) {}

  const TestMesh& mesh() const { return mesh_; }

  void cast(Api& api, std::size_t count, std::uint64_t seed, bool judged) {
    const auto rays = rays_at(mesh_, count, seed);
    v1::CastRaysResponse reply;
    const v1::CastRaysRequest request = rich_request(name_, rays);
    const Clock::time_point begin = Clock::now();
    const grpc::Status status = api.cast(request, &reply);
    time_ = Clock::now() - begin;
    ASSERT_TRUE(status.ok()) << status.error_message();
    ++progress_.casts;
    progress_.rays += rays.size();
    if (judged) judge(progress_, rays, reply, oracle_);
  }
  /// Of the last cast.
  Clock::duration time() const { return time_; }

 private:
  Progress& progress_;
  const std::string name_;
  const TestMesh mesh_;
  const BruteForce oracle_;
  Clock::duration time_{};
};

}  // namespace

void stream_updates(Progress& progress, ServedStress& stress, int port) {
  StreamingProducer producer(stress, port, 77);
  Pace pace(kStreamEvery);
  for (std::uint64_t batches = kBatchesPerCall; !progress.done(); batches += kBatchesPerCall) {
    producer.stream(batches, true);
    ++progress.connections;
    pace.wait();
  }
}

void moving_casts(Progress& progress, ServedStress& stress, int port, std::uint64_t seed) {
  CastingClient client(stress, port, seed);
  Pace pace(kCastEvery);
  for (std::uint64_t i = 0; !progress.done(); ++i) {
    client.cast(i % kOneIn == 0);
    ++progress.casts;
    pace.wait();
  }
}

void fixed_casts(Progress& progress, int port) {
  Api api(connect(port));
  const std::string name = "projects/p/scenes/fixed";
  FixedScene scene(progress, name, icosphere(6));
  api.make_scene(name, scene.mesh());
  Pace pace(kCastEvery);
  for (std::uint64_t i = 0; !progress.done(); ++i) {
    scene.cast(api, kRaysPerBatch, i, i % kOneIn == 0);
    progress.latencies.add(scene.time());
    pace.wait();
  }
}

void come_and_go(Progress& progress, int port) {
  Pace pace(kSceneEvery);
  for (std::uint64_t i = 1; !progress.done(); ++i) {
    const std::string name = "projects/p/scenes/short-" + std::to_string(i % 4);
    Api api(connect(port));
    ++progress.connections;
    FixedScene scene(progress, name, random_soup(2000, 0.2, i));
    api.make_scene(name, scene.mesh());
    ++progress.uploads;
    scene.cast(api, kRaysPerBatch, i, i % kOneIn == 0);
    const grpc::Status removed = api.remove(name);
    EXPECT_TRUE(removed.ok()) << removed.error_message();
    ++progress.scenes;
    pace.wait();
  }
}

}  // namespace sightline::tests::soak
