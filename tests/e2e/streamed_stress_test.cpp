// A producer streams updates of every kind, is disconnected and resumes, while others cast: every
// batch is applied once, and every answer equals brute force at the revision it names.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "tests/e2e/casting_client.h"
#include "tests/e2e/wire_updates.h"

namespace sightline::tests {
namespace {

constexpr int kProducers = 3;

// Draws batches ahead of the server's answers, with the expected result of each.
class Producer {
 public:
  Producer(ServedStress& stress, int port)
      : stress_(stress), api_(connect(port)), edits_(stress.meshes, 77) {}

  /// Streams until `count` batches are answered, or, if `cut`, sent: then the call is cancelled.
  void stream(std::uint64_t count, bool cut) {
    grpc::ClientContext context;
    const auto call = api_.scenes->StreamUpdates(&context);
    v1::StreamUpdatesRequest open;
    open.mutable_open()->set_scene(kMovingScene);
    open.mutable_open()->set_producer("stress");
    ASSERT_TRUE(call->Write(open));
    v1::StreamUpdatesResponse reply;
    ASSERT_TRUE(call->Read(&reply) && reply.has_opened());
    ASSERT_LE(reply.opened().last_committed(), batches_.size());
    ASSERT_GE(reply.opened().last_committed(), answered_);
    answered_ = reply.opened().last_committed();
    std::jthread reader([&] { read(*call); });
    std::uint64_t sent = answered_;
    while (sent < count && !testing::Test::HasFailure()) {
      if (sent == batches_.size()) draw();
      {
        std::unique_lock lock(mutex_);
        answered_changed_.wait(lock, [&] {
          return over_ || testing::Test::HasFailure() || sent < answered_ + reply.opened().window();
        });
        if (over_) ADD_FAILURE() << "the call has ended";
      }
      if (testing::Test::HasFailure() || !call->Write(batches_[sent++].message)) break;
    }
    if (cut || testing::Test::HasFailure()) {
      context.TryCancel();
    } else {
      call->WritesDone();
    }
    reader.join();
    over_ = false;
    const grpc::Status status = call->Finish();
    EXPECT_EQ(status.ok(), !cut) << status.error_message();
    if (!cut) {
      EXPECT_EQ(answered_, count);
    }
  }

 private:
  struct Batch {
    v1::StreamUpdatesRequest message;
    std::optional<Code> refusal;
    std::uint64_t revision = 0;  // The scene's revision after the batch
    std::vector<scenegraph::model::NodeId> put_nodes;
  };

  void draw() {
    RandomEdit edit = edits_.next(*stress_.history.latest());
    const std::lock_guard lock(mutex_);
    Batch& batch = batches_.emplace_back();
    batch.message.mutable_batch()->set_sequence(batches_.size());
    add_updates(*batch.message.mutable_batch(), edit.updates);
    batch.refusal = edit.refusal;
    batch.put_nodes = edit.put_nodes;
    if (edit.refusal) {
      batch.revision = stress_.history.latest()->revision();
      ++stress_.refused;
    } else {
      batch.revision = edit.after.revision();
      stress_.history.add(std::move(edit.after));
    }
  }

  void read(grpc::ClientReaderWriter<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>& call) {
    v1::StreamUpdatesResponse reply;
    while (call.Read(&reply)) {
      const std::lock_guard lock(mutex_);
      if (reply.has_ack()) check(reply.ack());
      if (reply.has_reject()) check(reply.reject());
      answered_changed_.notify_all();
    }
    const std::lock_guard lock(mutex_);
    over_ = true;
    answered_changed_.notify_all();
  }

  void check(const v1::UpdateAck& ack) {
    ASSERT_GT(ack.up_to_sequence(), 0u);
    ASSERT_LE(ack.up_to_sequence(), batches_.size());
    ASSERT_GE(ack.revision().revision(), batches_[ack.up_to_sequence() - 1].revision);
    ASSERT_LE(ack.revision().revision(), batches_.back().revision);
    ASSERT_EQ(ack.coalesced(), 0u);
    for (const v1::PutNodes& put : ack.put()) {
      ASSERT_EQ(std::vector<std::uint64_t>(put.nodes().begin(), put.nodes().end()),
                batches_[put.sequence() - 1].put_nodes);
    }
    answered_ = std::max(answered_, ack.up_to_sequence());
  }

  void check(const v1::UpdateReject& reject) {
    ASSERT_LE(reject.sequence(), batches_.size());
    const Batch& batch = batches_[reject.sequence() - 1];
    ASSERT_TRUE(batch.refusal) << reject.message();
    ASSERT_EQ(reject.code(), wire_code(*batch.refusal)) << reject.message();
    answered_ = std::max(answered_, reject.sequence());
  }

  ServedStress& stress_;
  Api api_;
  RandomEdits edits_;
  std::mutex mutex_;
  std::condition_variable answered_changed_;
  std::vector<Batch> batches_;
  std::uint64_t answered_ = 0;
  bool over_ = false;
};

class StreamedStress : public LiveServer {};

TEST_F(StreamedStress, EveryBatchIsAppliedOnceThroughBrokenCalls) {
  ServedStress stress(stress_updates(150));
  ASSERT_NO_FATAL_FAILURE(begin(api_, stress));
  std::atomic<bool> over{false};
  std::vector<std::jthread> clients;
  for (int i = 0; i < kProducers; ++i) {
    clients.emplace_back([&, i] {
      CastingClient client(stress, server_->port(), static_cast<std::uint64_t>(i));
      while (!over && !HasFailure()) client.cast();
    });
  }
  Producer producer(stress, server_->port());
  for (std::uint64_t part = 1; part <= 4 && !HasFailure(); ++part)
    producer.stream(stress.wanted * part / 5, true);
  if (!HasFailure()) producer.stream(stress.wanted, false);
  over = true;
  clients.clear();
  EXPECT_EQ(api_.get(kMovingScene).head().revision(), stress.history.latest()->revision());
  EXPECT_GT(stress.refused, stress.wanted / 20);
  EXPECT_GT(stress.casts, 0u);
  RecordProperty("casts", std::to_string(stress.casts));
}

}  // namespace
}  // namespace sightline::tests
