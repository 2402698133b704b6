// The queue of answers to a producer.
#include "server/updates/update_answers.h"

#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::updates {
namespace {

/// An id takes up to 10 bytes, so the message stays below 1 MiB.
constexpr std::size_t kMaxIdsPerAck = 65536;

void encode_put(std::uint64_t sequence, const std::vector<scenegraph::model::NodeId>& ids,
                v1::PutNodes& out) {
  out.set_sequence(sequence);
  out.mutable_nodes()->Assign(ids.begin(), ids.end());
}

}  // namespace

void UpdateAnswers::opened(const scenes::Producer& producer, std::uint32_t window,
                           const scenes::RevisionToken& revision) {
  v1::ProducerOpened& opened = *answers_.emplace_back().message.mutable_opened();
  opened.set_last_committed(producer.last_committed);
  opened.set_window(window);
  encode_revision(revision, *opened.mutable_revision());
  for (std::size_t i = 0; i < producer.put.size(); ++i) {
    const scenes::Producer::Put& put = producer.put[i];
    if (!put.nodes.empty()) encode_put(put.sequence, put.nodes, *opened.add_put());
  }
}

void UpdateAnswers::ack(std::uint64_t sequence, const scenes::RevisionToken& revision,
                        std::uint64_t coalesced, const std::vector<scenegraph::model::NodeId>& put,
                        std::size_t batches) {
  Answer& answer = open_ack(put.size());
  answer.batches += batches;
  answer.ids += put.size();
  v1::UpdateAck& ack = *answer.message.mutable_ack();
  ack.set_up_to_sequence(sequence);
  ack.set_coalesced(coalesced);
  encode_revision(revision, *ack.mutable_revision());
  if (put.empty()) return;
  encode_put(sequence, put, *ack.add_put());
}

void UpdateAnswers::reject(std::uint64_t sequence, const Error& error) {
  Answer& answer = answers_.emplace_back();
  answer.batches = 1;
  v1::UpdateReject& reject = *answer.message.mutable_reject();
  const grpc::Status status = exec::to_grpc(error);
  reject.set_sequence(sequence);
  reject.set_code(status.error_code());
  reject.set_reason(exec::reason_of(error));
  reject.set_message(status.error_message());
}

std::size_t UpdateAnswers::pop(v1::StreamUpdatesResponse& out) {
  out = std::move(answers_.front().message);
  const std::size_t batches = answers_.front().batches;
  answers_.pop_front();
  return batches;
}

UpdateAnswers::Answer& UpdateAnswers::open_ack(std::size_t ids) {
  const bool fits = !answers_.empty() && answers_.back().message.has_ack() &&
                    answers_.back().ids + ids <= kMaxIdsPerAck;
  return fits ? answers_.back() : answers_.emplace_back();
}

}  // namespace sightline::server::updates
