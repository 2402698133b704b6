// Calls that return at once, over a real connection.
#include "client/async_client.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <coroutine>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client {
namespace {

using tests::DownwardRays;
using tests::kScene;

constexpr std::uint32_t kCopies = 7;

class AsyncClientTest : public tests::LiveClient {
 protected:
  AsyncClientTest() {
    EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(kCopies), {}));
  }

  AsyncClient async_{client_};
};

/// A queue whose tasks the thread that has it runs.
class Loop {
 public:
  Executor executor() {
    return [this](std::function<void()> task) {
      const std::lock_guard lock(mutex_);
      tasks_.push_back(std::move(task));
      changed_.notify_one();
    };
  }
  void run_one() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !tasks_.empty(); });
    const auto task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    task();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
};

/// A coroutine that begins at once, without a result.
struct Detached {
  struct promise_type {
    Detached get_return_object() { return {}; }
    std::suspend_never initial_suspend() noexcept { return {}; }
    std::suspend_never final_suspend() noexcept { return {}; }
    void return_void() {}
    void unhandled_exception() { std::terminate(); }
  };
};

TEST_F(AsyncClientTest, ACastAnswersAsTheOneThatWaits) {
  const DownwardRays rays(1000, kCopies);
  std::vector<double> t(1000), expected(1000);
  std::vector<std::uint8_t> unanswered(bits_bytes(1000), 0xff);
  const auto waited = client_.cast(kScene, rays.columns(), {.t = expected});
  const HitColumns hits{.t = t, .unanswered = unanswered};
  const auto report = async_.cast(kScene, rays.columns(), hits).future().get();
  ASSERT_TRUE(waited && report) << report.error().message;
  EXPECT_EQ(t, expected);
  EXPECT_EQ(unanswered, std::vector<std::uint8_t>(bits_bytes(1000), 0));
  EXPECT_EQ(report->rays, waited->rays);
  EXPECT_EQ(report->hits, waited->hits);
  EXPECT_EQ(report->token, waited->token);
}

// Only the arrays of hits have to live on.
TEST_F(AsyncClientTest, RaysAreCopiedBeforeTheCallBegins) {
  auto rays = std::make_unique<DownwardRays>(3, kCopies);
  const std::vector<float> origins(rays->origins.begin(), rays->origins.end());
  std::vector<float> directions(rays->directions.begin(), rays->directions.end());
  std::vector<double> t(3), t_of_floats(3);
  auto call = async_.cast(kScene, rays->columns(), {.t = t});
  auto call_of_floats =
      async_.cast(kScene, RayColumns<const float>{origins, directions}, {.t = t_of_floats});
  std::fill(directions.begin(), directions.end(), 0.0F);
  rays.reset();
  ASSERT_TRUE(std::move(call).future().get());
  ASSERT_TRUE(std::move(call_of_floats).future().get());
  EXPECT_EQ(t, std::vector<double>(3, 4));
  EXPECT_EQ(t_of_floats, t);
}

TEST_F(AsyncClientTest, ManyCallsAreUnderWayAtATime) {
  constexpr std::size_t kCalls = 300;
  const DownwardRays rays(kCopies, kCopies);
  std::vector<std::array<std::uint64_t, kCopies>> node(kCalls);
  std::vector<std::future<Result<CastReport>>> casts;
  for (auto& each : node)
    casts.push_back(async_.cast(kScene, rays.columns(), {.node = each}).future());
  for (auto& cast : casts) {
    const auto report = cast.get();
    ASSERT_TRUE(report) << report.error().message;
  }
  for (const auto& each : node)
    ASSERT_EQ(each, (std::array<std::uint64_t, kCopies>{2, 3, 4, 5, 6, 7, 8}));
}

TEST_F(AsyncClientTest, TheOtherCallsAnswerToo) {
  const std::vector<double> positions{0.5, 0.5, 3};
  std::vector<double> distance(1);
  const PointColumns<const double> points{positions};
  auto nearest = async_.nearest(kScene, points, {.t = distance}).future();
  auto info = async_.server_info().future();
  auto scene = async_.get_scene(kScene).future();
  auto stats = async_.scene_stats(kScene).future();
  ASSERT_TRUE(nearest.get());
  EXPECT_EQ(distance[0], 2);
  EXPECT_EQ(info.get()->version, client_.server_info()->version);
  EXPECT_EQ(scene.get()->token, client_.get_scene(kScene)->token);
  EXPECT_EQ(stats.get()->instances_total, kCopies);

  const std::vector<float> floats(positions.begin(), positions.end());
  const PointColumns<const float> same{floats};
  distance[0] = 0;
  ASSERT_TRUE(async_.nearest(kScene, same, {.t = distance}).future().get());
  EXPECT_EQ(distance[0], 2);
}

TEST_F(AsyncClientTest, UpdatesAreAppliedOnce) {
  Transform moved = kIdentity;
  moved[3] = 100;
  const std::vector<Update> updates{SetTransforms{{2}, {moved}}};
  const ApplyOptions options{.request_id = "r"};
  const auto applied = async_.apply(kScene, updates, options).future().get();
  ASSERT_TRUE(applied) << applied.error().message;
  EXPECT_EQ(applied->revision, 2U);
  EXPECT_FALSE(applied->replayed);
  EXPECT_TRUE(async_.apply(kScene, updates, options).future().get()->replayed);
  EXPECT_EQ(client_.get_scene(kScene)->revision, 2U);
  const auto refused = async_.apply(kScene, std::vector<Update>{DeleteNode{99}}).future().get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kNotFound);
}

TEST_F(AsyncClientTest, APrefetchReportsItsProgress) {
  std::vector<std::uint64_t> seen;
  const auto report =
      async_
          .prefetch(kScene, {},
                    [&](const PrefetchReport& each) { seen.push_back(each.triangles_done); })
          .future()
          .get();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->triangles_done, report->triangles_total);
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.back(), report->triangles_total);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_EQ(async_.prefetch("projects/default/scenes/none").future().get().error().code,
            Code::kNotFound);
}

TEST_F(AsyncClientTest, TheExecutorRunsCompletions) {
  Loop loop;
  const AsyncClient on_loop(client_, loop.executor());
  std::thread::id ran_on;
  auto token = std::make_unique<int>(3);
  on_loop.get_scene(kScene).then([&, token = std::move(token)](const Result<SceneInfo>& scene) {
    EXPECT_TRUE(scene);
    EXPECT_EQ(*token, 3);
    ran_on = std::this_thread::get_id();
  });
  loop.run_one();
  EXPECT_EQ(ran_on, std::this_thread::get_id());
  // A future needs no executor, so that the loop's thread may wait for it.
  EXPECT_TRUE(on_loop.get_scene(kScene).future().get());
}

Detached look_twice(const AsyncClient& async, std::vector<Result<CastReport>>& reports) {
  const DownwardRays rays(1, kCopies);
  std::vector<double> t(1);
  for (int i = 0; i < 2; ++i) {
    auto call = async.cast(kScene, rays.columns(), {.t = t});
    reports.push_back(co_await std::move(call));
    EXPECT_EQ(t[0], 4);
  }
}

TEST_F(AsyncClientTest, CoroutinesAreResumedOnTheExecutor) {
  Loop loop;
  const AsyncClient on_loop(client_, loop.executor());
  std::vector<Result<CastReport>> reports;
  look_twice(on_loop, reports);
  EXPECT_TRUE(reports.empty());
  for (std::size_t i = 1; i <= 2; ++i) {
    loop.run_one();
    ASSERT_EQ(reports.size(), i);
    EXPECT_TRUE(reports.back());
  }
}

TEST_F(AsyncClientTest, ACompletionMayBeginCalls) {
  const auto got = std::make_shared<std::promise<Result<SceneStats>>>();
  async_.get_scene(kScene).then([this, got](const Result<SceneInfo>& scene) {
    async_.scene_stats(scene->name).then([got](Result<SceneStats> stats) {
      got->set_value(std::move(stats));
    });
  });
  EXPECT_TRUE(got->get_future().get());
}

TEST_F(AsyncClientTest, ErrorsAreThoseOfTheCallsThatWait) {
  const DownwardRays rays(2, kCopies);
  std::vector<double> t(3);
  const auto wrong = async_.cast(kScene, rays.columns(), {.t = t}).future().get();
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message, client_.cast(kScene, rays.columns(), {.t = t}).error().message);
  EXPECT_EQ(wrong.error().code, Code::kInvalidArgument);
  const auto nowhere = async_.get_scene("projects/default/scenes/none").future().get();
  EXPECT_EQ(nowhere.error().code, Code::kNotFound);
  EXPECT_FALSE(nowhere.error().reason.empty());
  const std::vector<Update> uneven{SetTransforms{{1, 2}, {kIdentity}}};
  EXPECT_EQ(async_.apply(kScene, uneven).future().get().error().message,
            "update 0: 2 nodes but 1 transforms");
  stop_server();
  EXPECT_EQ(async_.server_info().future().get().error().code, Code::kUnavailable);
}

// Even an error of the arguments, which is known at once, must not complete under a lock that the
// caller holds.
TEST_F(AsyncClientTest, NoCompletionRunsWithinThen) {
  std::mutex held;
  const auto completed = std::make_shared<std::promise<Result<CastReport>>>();
  {
    const std::lock_guard lock(held);
    std::vector<double> t(3);
    async_.cast(kScene, DownwardRays(2, kCopies).columns(), {.t = t})
        .then([&held, completed](Result<CastReport> report) {
          { const std::lock_guard inner(held); }
          completed->set_value(std::move(report));
        });
  }
  EXPECT_FALSE(completed->get_future().get());
}

TEST_F(AsyncClientTest, ACallThatDoesNotBeginIsNotSent) {
  const std::vector<Update> updates{DeleteNode{2}};
  static_cast<void>(async_.apply(kScene, updates));
  EXPECT_EQ(client_.get_scene(kScene)->revision, 1U);
}

TEST_F(AsyncClientTest, AThreadOfGrpcThatThrowsEndsTheProgram) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        std::vector<double> t(3);
        async_.cast(kScene, DownwardRays(2, kCopies).columns(), {.t = t})
            .then([](const Result<CastReport>&) { throw std::runtime_error("thrown"); });
        std::promise<void>().get_future().wait();
      },
      "thrown");
}

}  // namespace
}  // namespace sightline::client
