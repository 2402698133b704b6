// The queue of answers to a producer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/node.h"
#include "server/scenes/idempotency.h"
#include "server/scenes/names.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

/// Consecutive acks are merged while the message stays small. The queue therefore has at most twice
/// as many answers as batches.
class UpdateAnswers {
 public:
  void opened(const scenes::Producer& producer, std::uint32_t window,
              const scenes::RevisionToken& revision);
  /// Answers an applied batch; `batches` is 0 for a repeated one. `put`: the ids of the nodes that
  /// it put.
  void ack(std::uint64_t sequence, const scenes::RevisionToken& revision, std::uint64_t coalesced,
           const std::vector<scenegraph::model::NodeId>& put, std::size_t batches = 1);
  void reject(std::uint64_t sequence, const Error& error);

  bool empty() const { return answers_.empty(); }
  void clear() { answers_.clear(); }
  /// Removes the oldest answer. Returns how many batches it answers.
  std::size_t pop(v1::StreamUpdatesResponse& out);

 private:
  struct Answer {
    v1::StreamUpdatesResponse message;
    std::size_t batches = 0;
    std::size_t ids = 0;
  };
  Answer& open_ack(std::size_t ids);

  std::deque<Answer> answers_;
};

}  // namespace sightline::server::updates
