// A producer that streams random updates, is disconnected and resumes.
#include "tests/e2e/streaming_producer.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "tests/e2e/wire_updates.h"

namespace sightline::tests {

void StreamingProducer::stream(std::uint64_t count, bool cut) {
  grpc::ClientContext context;
  const auto call = api_.scenes->StreamUpdates(&context);
  const std::uint64_t window = open(*call);
  if (window == 0) {
    context.TryCancel();
    ADD_FAILURE() << "the call was not opened: " << call->Finish().error_message();
    return;
  }
  std::jthread reader([&] { read(*call); });
  write(*call, count, window);
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

/// The window of the call; 0: it was not opened.
std::uint64_t StreamingProducer::open(Call& call) {
  v1::StreamUpdatesRequest open;
  open.mutable_open()->set_scene(kMovingScene);
  open.mutable_open()->set_producer("stress");
  v1::StreamUpdatesResponse reply;
  if (!call.Write(open) || !call.Read(&reply) || !reply.has_opened()) return 0;
  const std::uint64_t committed = reply.opened().last_committed();
  EXPECT_GE(committed, answered_);
  EXPECT_LE(committed, drawn());
  if (committed >= answered_ && committed <= drawn()) answered(committed);
  return reply.opened().window();
}

void StreamingProducer::write(Call& call, std::uint64_t count, std::uint64_t window) {
  for (std::uint64_t sent = answered_; sent < count && !testing::Test::HasFailure(); ++sent) {
    std::unique_lock lock(mutex_);
    if (sent == drawn()) draw();
    answered_changed_.wait(
        lock, [&] { return over_ || testing::Test::HasFailure() || sent < answered_ + window; });
    if (over_) ADD_FAILURE() << "the call has ended";
    if (testing::Test::HasFailure()) return;
    const v1::StreamUpdatesRequest message = batch(sent + 1).message;
    lock.unlock();
    if (!call.Write(message)) return;
  }
}

/// With the mutex held.
void StreamingProducer::draw() {
  RandomEdit edit = edits_.next(*stress_.history.latest());
  const std::uint64_t sequence = drawn() + 1;
  Batch& batch = unanswered_.emplace_back();
  batch.message.mutable_batch()->set_sequence(sequence);
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

void StreamingProducer::read(Call& call) {
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

void StreamingProducer::check(const v1::UpdateAck& ack) {
  ASSERT_GT(ack.up_to_sequence(), answered_);
  ASSERT_LE(ack.up_to_sequence(), drawn());
  ASSERT_GE(ack.revision().revision(), batch(ack.up_to_sequence()).revision);
  ASSERT_LE(ack.revision().revision(), unanswered_.back().revision);
  ASSERT_EQ(ack.coalesced(), 0u);
  for (const v1::PutNodes& put : ack.put()) {
    ASSERT_GT(put.sequence(), answered_);
    ASSERT_LE(put.sequence(), drawn());
    ASSERT_EQ(std::vector<std::uint64_t>(put.nodes().begin(), put.nodes().end()),
              batch(put.sequence()).put_nodes);
  }
  answered(ack.up_to_sequence());
}

void StreamingProducer::check(const v1::UpdateReject& reject) {
  ASSERT_GT(reject.sequence(), answered_);
  ASSERT_LE(reject.sequence(), drawn());
  const Batch& refused = batch(reject.sequence());
  ASSERT_TRUE(refused.refusal) << reject.message();
  ASSERT_EQ(reject.code(), wire_code(*refused.refusal)) << reject.message();
  answered(reject.sequence());
}

void StreamingProducer::answered(std::uint64_t up_to) {
  unanswered_.erase(unanswered_.begin(),
                    unanswered_.begin() + static_cast<std::ptrdiff_t>(up_to - answered_));
  answered_ = up_to;
}

}  // namespace sightline::tests
