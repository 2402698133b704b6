// Assembles the batches of one producer from messages.
#include "server/updates/update_batches.h"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "server/updates/update_codec.h"

namespace sightline::server::updates {

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
  auto ticket = admission_.admit(0, bytes);
  if (!ticket) return ticket.error();
  auto updates = decode_updates(message.updates(), blobs_, batch_.updates.size());
  if (!updates) {
    refuse(updates.error());
    return {};
  }
  batch_.tickets.push_back(std::move(*ticket));
  batch_.bytes += bytes;
  batch_.updates.insert(batch_.updates.end(), std::make_move_iterator(updates->begin()),
                        std::make_move_iterator(updates->end()));
  return {};
}

void UpdateBatches::refuse(Error error) {
  batch_.bad = std::move(error);
  batch_.updates = {};
  batch_.tickets.clear();
  batch_.bytes = 0;
}

}  // namespace sightline::server::updates
