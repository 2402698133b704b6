// A producer that streams random updates, is disconnected and resumes.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "tests/e2e/casting_client.h"

namespace sightline::tests {

/// Draws batches ahead of the server's answers, with the expected result of each, and fails the
/// test if an answer differs. Threads: one caller.
class StreamingProducer {
 public:
  StreamingProducer(ServedStress& stress, int port, std::uint64_t seed)
      : stress_(stress), api_(connect(port)), edits_(stress.meshes, seed) {}

  /// Streams until `count` batches in all are answered, or, if `cut`, sent: then the call is
  /// cancelled, and the next begins with what was not answered.
  void stream(std::uint64_t count, bool cut);

 private:
  using Call = grpc::ClientReaderWriter<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>;
  struct Batch {
    v1::StreamUpdatesRequest message;
    std::optional<Code> refusal;
    std::uint64_t revision = 0;  // The scene's revision after the batch
    std::vector<scenegraph::model::NodeId> put_nodes;
  };

  std::uint64_t open(Call& call);
  void write(Call& call, std::uint64_t count, std::uint64_t window);
  const Batch& batch(std::uint64_t sequence) const { return unanswered_[sequence - 1 - answered_]; }
  std::uint64_t drawn() const { return answered_ + unanswered_.size(); }
  void draw();
  void read(Call& call);
  void check(const v1::UpdateAck& ack);
  void check(const v1::UpdateReject& reject);
  void answered(std::uint64_t up_to);

  ServedStress& stress_;
  Api api_;
  RandomEdits edits_;
  std::mutex mutex_;
  std::condition_variable answered_changed_;
  std::deque<Batch> unanswered_;
  std::uint64_t answered_ = 0;
  bool over_ = false;
};

}  // namespace sightline::tests
