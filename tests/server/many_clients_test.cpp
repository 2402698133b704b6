// Many clients at once, many one after another, and a server that pauses for seconds.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "tests/client/support/temp_dir.h"
#include "tests/server/support/child_server.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

/// As many files as this process may open.
void open_many_files() {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
}

class ManyClients : public testing::Test {
 protected:
  ManyClients() : child_({"--listen", "127.0.0.1:0", "--data-dir", data_.path("data")}) {
    open_many_files();
    port_ = child_.port();
    Api(connect(port_)).make_scene(kScene, cube());
  }

  /// Waits until the server has closed what its clients have.
  void expect_files(std::uint64_t most) {
    for (int i = 0; i < 1000 && child_.open_files() > most; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_LE(child_.open_files(), most);
  }

  grpc::Status cast(Api& api) const {
    v1::CastRaysResponse reply;
    return api.cast(cast_request(kScene, rays_downward(4)), &reply);
  }

  TempDir data_;
  ChildServer child_;
  int port_ = 0;
};

TEST_F(ManyClients, AThousandConnectionsAreServedAtOnce) {
  constexpr std::size_t kCount = 1000, kAlone = 10;
  const std::uint64_t before = child_.open_files();
  {
    std::vector<std::unique_ptr<Api>> clients;
    for (std::size_t i = 0; i < kCount; ++i)
      clients.push_back(std::make_unique<Api>(connect(port_)));
    EXPECT_GE(child_.open_files(), before + kCount);
    for (const auto& client : clients) {
      const grpc::Status status = cast(*client);
      ASSERT_TRUE(status.ok()) << status.error_message();
    }
  }
  expect_files(before + kAlone);
}

TEST_F(ManyClients, TenThousandShortConnectionsLeaveNothingBehind) {
  constexpr int kThreads = 4, kEach = 2500;
  constexpr std::uint64_t kAlone = 10;
  const std::uint64_t before = child_.open_files();
  std::atomic<int> served{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < kEach; ++i) {
          Api api(connect(port_));
          served += cast(api).ok();
        }
      });
    }
  }
  EXPECT_EQ(served, kThreads * kEach);
  expect_files(before + kAlone);
}

TEST_F(ManyClients, AServerThatPausesLosesNothing) {
  constexpr int kClients = 4;
  std::atomic<bool> over{false};
  std::atomic<int> casts{0}, updates{0}, failed{0};
  std::vector<std::jthread> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.emplace_back([&] {
      Api api(connect(port_));
      while (!over) (cast(api).ok() ? casts : failed)++;
    });
  }
  clients.emplace_back([&] {
    Api api(connect(port_));
    while (!over) (api.apply(kScene, {put_node(-1)}).ok() ? updates : failed)++;
  });
  const auto wait_for_more = [&](int than) {
    while (updates + failed <= than || casts == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  wait_for_more(10);
  child_.signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::seconds(3));
  const int acknowledged = updates;
  child_.signal(SIGCONT);
  wait_for_more(acknowledged + 10);
  over = true;
  clients.clear();
  EXPECT_EQ(failed, 0);
  // Revision 1 made the scene's first node.
  EXPECT_EQ(Api(connect(port_)).get(kScene).head().revision(),
            static_cast<std::uint64_t>(updates) + 1);
}

}  // namespace
}  // namespace sightline::tests
