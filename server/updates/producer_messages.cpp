// Messages of a producer's stream: batches that arrive in parts, and the queue of answers.
#include "server/updates/producer_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/codec/update_codec.h"
#include "server/exec/rpc_status.h"
#include "server/scenes/update_log.h"

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

Result<UpdateBatches::Received> UpdateBatches::accept(const v1::UpdateBatch& message) {
  if (const Status good = check_sequence(message.sequence()); !good) return good.error();
  const bool repeat = message.sequence() <= last_;
  if (!repeat) {
    if (!open_) {
      batch_ = {};
      batch_.sequence = message.sequence();
    }
    if (const Status appended = append(message); !appended) return appended.error();
  }
  open_ = message.more();
  open_sequence_ = message.sequence();
  if (open_) return Received::kPart;
  if (repeat) return Received::kRepeat;
  last_ = message.sequence();
  return Received::kBatch;
}

UpdateBatch UpdateBatches::batch() { return std::exchange(batch_, {}); }

Status UpdateBatches::check_sequence(std::uint64_t sequence) const {
  if (open_ && sequence != open_sequence_) {
    return Error{Code::kInvalidArgument,
                 fmt::format("batch {} was to go on, but a message of batch {} came",
                             open_sequence_, sequence),
                 "BATCH_NOT_FINISHED"};
  }
  if (sequence >= 1 && sequence <= last_ + 1) return {};
  return Error{Code::kInvalidArgument,
               fmt::format("expected batch {}, or one before it again, but got batch {}", last_ + 1,
                           sequence),
               "SEQUENCE_GAP"};
}

Status UpdateBatches::append(const v1::UpdateBatch& message) {
  const std::size_t bytes = message.ByteSizeLong();
  if (batch_.bad) return {};  // the rest of the batch is ignored
  if (batch_.bytes + bytes > kMaxBatchBytes) {
    refuse({Code::kResourceExhausted,
            fmt::format("the batch has more than the limit of {} bytes", kMaxBatchBytes),
            "BATCH_TOO_LARGE"});
    return {};
  }
  auto updates = codec::decode_updates(message.updates(), blobs_, batch_.updates.size());
  if (!updates) {
    refuse(updates.error());
    return {};
  }
  // Small updates take more bytes than their messages.
  const auto held = std::max<std::size_t>(bytes, scenes::bytes_of(*updates));
  if (Status admitted = admit(bytes, held); !admitted) return admitted;
  batch_.bytes += bytes;
  batch_.updates.insert(batch_.updates.end(), std::make_move_iterator(updates->begin()),
                        std::make_move_iterator(updates->end()));
  return {};
}

Status UpdateBatches::admit(std::size_t bytes, std::size_t held) {
  if (Status spent = quotas_.spend(caller_, 0, bytes); !spent) return spent;
  auto batches = batch_admission_.admit(caller_, 0, held);
  if (!batches) return batches.error();
  auto all = admission_.admit(caller_, 0, held);
  if (!all) return all.error();
  batch_.tickets.push_back(std::move(*batches));
  batch_.tickets.push_back(std::move(*all));
  return {};
}

void UpdateBatches::refuse(Error error) {
  batch_.bad = std::move(error);
  batch_.updates = {};
  batch_.tickets.clear();
  batch_.bytes = 0;
}

v1::Durability encode_durability(scenes::Durability durability) {
  return durability == scenes::Durability::kCommitted ? v1::DURABILITY_COMMITTED
                                                      : v1::DURABILITY_RELAXED;
}

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

void UpdateAnswers::ack(const Applied& applied, const std::vector<scenegraph::model::NodeId>& put) {
  Answer& answer = open_ack(put.size());
  answer.batches += applied.batches;
  answer.ids += put.size();
  v1::UpdateAck& ack = *answer.message.mutable_ack();
  ack.set_up_to_sequence(applied.sequence);
  ack.set_coalesced(applied.coalesced);
  // An ack has the weakest durability of what it answers.
  if (ack.durability() != v1::DURABILITY_RELAXED)
    ack.set_durability(encode_durability(applied.durability));
  encode_revision(applied.revision, *ack.mutable_revision());
  if (put.empty()) return;
  encode_put(applied.sequence, put, *ack.add_put());
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
