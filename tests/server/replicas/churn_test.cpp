// A scene that is removed and created again, through any of several servers, while others write to
// it, read it and watch it.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <deque>
#include <initializer_list>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/replicas/replicas.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

constexpr int kScenes = 30;  // made one after the other

/// One client of all servers, which asks any of them.
class Wanderer {
 public:
  Wanderer(std::initializer_list<ReplicaServer*> servers, std::uint64_t seed) : random_(seed) {
    for (ReplicaServer* server : servers) apis_.emplace_back(server->connect_again());
  }

  Api& any() { return apis_[random_.below(apis_.size())]; }
  std::uint64_t below(std::uint64_t n) { return random_.below(n); }

 private:
  std::deque<Api> apis_;
  Random random_;
};

/// What may become of a call about a scene that comes and goes.
void expect_usual(const grpc::Status& status) {
  using enum grpc::StatusCode;
  const auto usual = {OK, NOT_FOUND, ALREADY_EXISTS, ABORTED, UNAVAILABLE};
  EXPECT_NE(std::ranges::find(usual, status.error_code()), usual.end())
      << status.error_code() << " " << status.error_message();
}

class ReplicaChurn : public ReplicaTest {
 protected:
  void make_scenes(Wanderer& client) const {
    for (int i = 0; i < kScenes; ++i) {
      expect_usual(client.any().remove(kScene));
      expect_usual(client.any().create(kScene));
      for (std::uint64_t n = client.below(4); n > 0; --n)
        expect_usual(client.any().apply(kScene, {put_node(-1, mesh_)}));
    }
  }
  void apply(Wanderer& client, const std::string& name) const {
    for (int i = 0; !done_; ++i) {
      const auto request = request_of(name + std::to_string(i), {put_node(-1, mesh_)});
      v1::ApplyUpdatesResponse reply;
      expect_usual(apply_request(client.any(), request, &reply));
    }
  }
  void stream(Wanderer& client, const std::string& name) const {
    while (!done_) {
      UpdateStream stream(client.any());
      v1::StreamUpdatesResponse answer;
      if (!stream.send_open(kScene, name) || !stream.read(answer)) continue;
      const std::uint64_t before = answer.opened().last_committed(), last = before + 6;
      for (std::uint64_t i = before + 1; i <= last; ++i) stream.send(i, {put_node(-1)});
      std::uint64_t acknowledged = before;
      for (std::uint64_t left = client.below(4); left > 0 && acknowledged < last; --left) {
        if (!stream.read(answer)) break;
        acknowledged = answer.ack().up_to_sequence();
      }
    }
  }
  void cast(Wanderer& client) const {
    const auto rays = rays_downward(200);
    while (!done_) {
      v1::CastRaysResponse reply;
      expect_usual(client.any().cast(cast_request(kScene, rays), &reply));
    }
  }
  void watch(Wanderer& client) const {
    while (!done_) {
      grpc::ClientContext context;
      v1::WatchSceneRequest request;
      request.set_scene(kScene);
      const auto reader = client.any().scenes->WatchScene(&context, request);
      v1::WatchSceneResponse message;
      for (std::uint64_t left = client.below(8); left > 0 && reader->Read(&message); --left) {
      }
      context.TryCancel();
      while (reader->Read(&message)) {
      }
      static_cast<void>(reader->Finish());
    }
  }

  std::string mesh_;
  std::atomic<bool> done_{false};
};

TEST_F(ReplicaChurn, AllServersEndWithTheLastScene) {
  start_three();
  mesh_ = a_->api().add_mesh(planar_sheet(2));
  std::deque<Wanderer> clients;
  for (std::uint64_t seed = 0; seed < 8; ++seed)
    clients.emplace_back(std::initializer_list<ReplicaServer*>{a_.get(), b_.get(), c_.get()}, seed);
  std::vector<std::thread> threads;
  threads.emplace_back([&] { apply(clients[1], "one-"); });
  threads.emplace_back([&] { apply(clients[2], "two-"); });
  threads.emplace_back([&] { stream(clients[3], "robot"); });
  threads.emplace_back([&] { stream(clients[4], "robot"); });
  threads.emplace_back([&] { cast(clients[5]); });
  threads.emplace_back([&] { cast(clients[6]); });
  threads.emplace_back([&] { watch(clients[7]); });
  make_scenes(clients[0]);
  done_ = true;
  for (std::thread& thread : threads) thread.join();
  v1::ApplyUpdatesResponse last;
  expect_usual(c_->api().remove(kScene));
  ASSERT_TRUE(a_->api().create(kScene).ok());
  ASSERT_TRUE(b_->api().apply(kScene, {put_node(-1, mesh_)}, &last).ok());
  EXPECT_EQ(last.revision().revision(), 1u);
  for (ReplicaServer* server : {a_.get(), b_.get(), c_.get()}) {
    v1::CastRaysResponse reply;
    const grpc::Status status = cast_at(server->api(), last.revision().token(), &reply);
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(reply.served().token(), last.revision().token());
  }
}

}  // namespace
}  // namespace sightline::tests
