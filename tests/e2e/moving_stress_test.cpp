// Updates and casts of every kind from several clients of one server, in random order: every answer
// equals brute force at the revision it names.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "tests/e2e/casting_client.h"
#include "tests/e2e/wire_updates.h"

namespace sightline::tests {
namespace {

constexpr int kClients = 4;

// Updates the scene and casts at it, at random.
class Actor : public CastingClient {
 public:
  Actor(ServedStress& stress, int port, std::uint64_t seed)
      : CastingClient(stress, port, seed), edits_(stress.meshes, seed + 1000), seed_(seed) {}

  void run() {
    while (!stress_.done()) {
      if (random_.below(3) == 0) {
        update();
      } else {
        cast();
      }
    }
  }

 private:
  void update() {
    const auto now = stress_.history.latest();
    RandomEdit edit = edits_.next(*now);
    v1::ApplyUpdatesRequest request;
    request.set_scene(kMovingScene);
    request.set_expected_revision(now->revision());
    request.set_request_id(std::to_string(seed_) + "." + std::to_string(++requests_));
    add_updates(request, edit.updates);
    v1::ApplyUpdatesResponse reply;
    const grpc::Status status = apply(request, reply);
    if (status.error_code() == grpc::StatusCode::ABORTED) {
      ++stress_.outrun;
      return;
    }
    ASSERT_EQ(status.ok(), !edit.refusal) << status.error_message();
    if (edit.refusal) {
      ASSERT_EQ(status.error_code(), wire_code(*edit.refusal)) << status.error_message();
      ++stress_.refused;
      return;
    }
    ASSERT_FALSE(reply.replayed());
    ASSERT_EQ(reply.revision().revision(), edit.after.revision());
    ASSERT_EQ(std::vector<std::uint64_t>(reply.nodes().begin(), reply.nodes().end()),
              edit.put_nodes);
    record_revision(reply.revision());
    stress_.history.add(std::move(edit.after));
    ++stress_.applied;
    if (random_.below(8) == 0) repeat(request, reply);
  }

  // As if the answer had been lost.
  void repeat(const v1::ApplyUpdatesRequest& request, const v1::ApplyUpdatesResponse& first) {
    v1::ApplyUpdatesResponse again;
    const grpc::Status status = apply(request, again);
    ASSERT_TRUE(status.ok()) << status.error_message();
    ASSERT_TRUE(again.replayed());
    ASSERT_EQ(again.revision().revision(), first.revision().revision());
    ASSERT_EQ(again.nodes_size(), first.nodes_size());
  }

  grpc::Status apply(const v1::ApplyUpdatesRequest& request, v1::ApplyUpdatesResponse& reply) {
    grpc::ClientContext context;
    return api_.scenes->ApplyUpdates(&context, request, &reply);
  }

  RandomEdits edits_;
  std::uint64_t seed_, requests_ = 0;
};

class MovingStress : public LiveServer {};

TEST_F(MovingStress, EveryAnswerEqualsBruteForceAtItsRevision) {
  ServedStress stress(stress_updates(150));
  ASSERT_NO_FATAL_FAILURE(begin(api_, stress));
  std::vector<std::jthread> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.emplace_back(
        [&, i] { Actor(stress, server_->port(), static_cast<std::uint64_t>(i)).run(); });
  }
  clients.clear();
  EXPECT_GE(stress.applied, stress.wanted);
  EXPECT_GT(stress.refused, stress.wanted / 20);
  EXPECT_GT(stress.casts, stress.wanted / 2);
  EXPECT_GT(stress.hits, stress.casts);
  EXPECT_LT(stress.gone, stress.casts);
  for (const auto& [name, count] : {std::pair{"casts", &stress.casts},
                                    {"refused", &stress.refused},
                                    {"outrun", &stress.outrun},
                                    {"hits", &stress.hits},
                                    {"gone", &stress.gone}})
    RecordProperty(name, std::to_string(*count));
}

}  // namespace
}  // namespace sightline::tests
