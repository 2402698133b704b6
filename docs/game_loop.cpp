// A loop that casts rays without waiting for them: it makes a scene from arrays, and in each tick
// moves what a ray has hit. Build it with the tests, run it beside a server, whose endpoint may be
// its argument.
#include <array>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "client/async_client.h"

using namespace sightline::client;

namespace {

constexpr const char* kScene = "projects/default/scenes/yard";
constexpr int kTicks = 5;

// The tasks of the loop. Threads of gRPC put completions here, and the loop runs them.
class Tasks {
 public:
  void put(std::function<void()> task) {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    changed_.notify_one();
  }
  // A game would not wait, and draw its frame instead.
  void run() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !tasks_.empty(); });
    const auto tasks = std::exchange(tasks_, {});
    lock.unlock();
    for (const auto& task : tasks) task();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::function<void()>> tasks_;
};

// What a cast of one ray reads and writes. It must live until the cast has completed.
struct Look {
  std::array<double, 3> origin{0.25, 0.5, 9}, direction{0, 0, -1};
  std::array<double, 1> t{};
  std::array<std::uint64_t, 1> node{};
};

int failed(const Error& error) { return std::puts(error.message.c_str()), 1; }

}  // namespace

int main(int argc, char** argv) {
  const auto client = Client::connect(argc > 1 ? argv[1] : "127.0.0.1:50151");
  if (!client) return failed(client.error());

  const std::vector<float> vertices{-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};  // (n, 3)
  const std::vector<std::uint32_t> faces{0, 1, 2, 0, 2, 3};                   // (n, 3)
  const auto made = client->import_arrays(kScene, vertices, faces, {.replace = true});
  if (!made) return failed(made.error());

  Look first;
  const RayColumns<const double> ray{.origins = first.origin, .directions = first.direction};
  const auto seen = client->cast(kScene, ray, {.t = first.t, .node = first.node});
  if (!seen) return failed(seen.error());
  std::printf("before: node %d is %g below\n", static_cast<int>(first.node[0]), first.t[0]);

  Tasks tasks;
  const std::stop_source stop;  // ends what is under way, when the player leaves
  const AsyncClient async(*client, [&](std::function<void()> task) { tasks.put(std::move(task)); });
  int ticks = 0, exit_code = 0;
  const auto end = [&](const Error& error) { ticks = kTicks, exit_code = failed(error); };

  const auto look = [&](const std::string& token) {
    const auto now = std::make_shared<Look>();
    const RayColumns<const double> rays{.origins = now->origin, .directions = now->direction};
    const HitColumns hits{.t = now->t, .node = now->node};
    async.cast(kScene, rays, hits, {.consistency = {.at_least = token}, .stop = stop.get_token()})
        .then([&, now](const Result<CastReport>& report) {
          if (!report) return end(report.error());
          std::printf("tick %d: node %d is %g below\n", ticks, static_cast<int>(now->node[0]),
                      now->t[0]);
          ++ticks;
        });
  };

  for (int begun = -1; ticks < kTicks; tasks.run()) {
    if (begun == ticks) continue;
    begun = ticks;
    Transform lower = kIdentity;
    lower[11] = -ticks;
    const std::array<Update, 1> move{SetTransforms{first.node, {lower}}};
    async.apply(kScene, move, {.stop = stop.get_token()}).then([&](const Result<Applied>& applied) {
      applied ? look(applied->token) : end(applied.error());
    });
  }
  return exit_code;
}
