// Casts and prefetches at servers that answer for shards, while callers give up, the scene moves
// and goes, and one of the servers comes and goes.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <thread>
#include <vector>

#include "tests/server/replicas/shards.h"
#include "tests/server/updates/update_stream.h"

namespace sightline::tests {
namespace {

constexpr int kRounds = 8;

class ShardChurn : public Shards {
 protected:
  /// Callers of the first two servers: the third comes and goes.
  Api connect_to(std::uint64_t number) const {
    return Api(connect(address(number % (kServers - 1))));
  }

  /// Half of the callers give up soon.
  static void give_up_soon(Random& random, grpc::ClientContext& context) {
    if (random.below(2) != 0) return;
    context.set_deadline(std::chrono::system_clock::now() +
                         std::chrono::microseconds(random.below(6000)));
  }
  /// With their sides, by one of the rules.
  static void ask_points(Random& random, Api& api, std::span<const accel::geometry::Ray> points) {
    v1::QueryPointsRequest request = nearest_of(v1::QUERY_KIND_CLOSEST, points);
    request.add_fields(v1::HIT_FIELD_SIGNED);
    request.set_side_rule(static_cast<v1::SideRule>(1 + random.below(3)));
    request.set_allow_partial(random.below(2) == 0);
    grpc::ClientContext context;
    give_up_soon(random, context);
    v1::QueryPointsResponse reply;
    static_cast<void>(api.rays->QueryPoints(&context, request, &reply));
  }
  void cast(std::uint64_t seed) const {
    Random random(seed);
    Api api = connect_to(seed);
    const auto some = rays();
    while (!done_) {
      for (const auto& [kind, fields] : kFields) {
        v1::CastRaysRequest request = cast_of(kind, some);
        request.set_allow_partial(random.below(2) == 0);
        grpc::ClientContext context;
        give_up_soon(random, context);
        v1::CastRaysResponse reply;
        static_cast<void>(api.rays->CastRays(&context, request, &reply));
      }
      ask_points(random, api, some);
    }
  }
  /// Leaves after none to two of the reports.
  void prefetch(std::uint64_t seed) const {
    Random random(seed);
    Api api = connect_to(seed);
    while (!done_) {
      v1::PrefetchRequest request;
      request.set_scene(kScene);
      if (random.below(2) == 0) *request.mutable_rays() = cast_request(kScene, rays()).rays();
      grpc::ClientContext context;
      const auto call = api.rays->Prefetch(&context, request);
      v1::PrefetchResponse report;
      for (std::uint64_t left = random.below(3); left > 0 && call->Read(&report); --left) {
      }
      context.TryCancel();
      while (call->Read(&report)) {
      }
      static_cast<void>(call->Finish());
    }
  }
  void move(std::uint64_t seed) const {
    Random random(seed);
    Api api = connect_to(seed);
    while (!done_) {
      const grpc::Status moved =
          api.apply(kScene, {move_to(2 + random.below(36), random.uniform(0, 20))});
      EXPECT_TRUE(moved.ok() || moved.error_code() == grpc::StatusCode::NOT_FOUND ||
                  moved.error_code() == grpc::StatusCode::UNAVAILABLE)
          << moved.error_message();
    }
  }

  std::atomic<bool> done_{false};
};

TEST_F(ShardChurn, AnswersAsOneServerAfterwards) {
  start_shards();
  make_grid();
  std::vector<std::thread> threads;
  for (std::uint64_t seed = 0; seed < 4; ++seed) threads.emplace_back([this, seed] { cast(seed); });
  for (std::uint64_t seed = 4; seed < 6; ++seed)
    threads.emplace_back([this, seed] { prefetch(seed); });
  threads.emplace_back([this] { move(6); });
  for (int round = 0; round < kRounds; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (round % 4 == 3) {
      ASSERT_TRUE(plain_->api().remove(kScene).ok());
      make_grid();
    } else {
      servers_[kServers - 1].reset();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      start_shard(kServers - 1);
    }
  }
  done_ = true;
  for (std::thread& thread : threads) thread.join();
  v1::ApplyUpdatesResponse last;
  ASSERT_TRUE(api(2).apply(kScene, {move_to(2, 1)}, &last).ok());
  for (std::size_t i = 0; i < kServers; ++i) {  // connects to the third again
    wait_until([&] {
      v1::CastRaysResponse reply;
      return api(i).cast(cast_of(v1::QUERY_KIND_CLOSEST, rays()), &reply).ok();
    });
  }
  expect_as_one_server(rays(), last.revision().token());
}

}  // namespace
}  // namespace sightline::tests
