// Applies the batches of one producer.
#include "server/updates/producer_session.h"

#include <utility>

#include "server/updates/coalesce.h"

namespace sightline::server::updates {
namespace {

/// Whether the server failed or the call ended. The batch may succeed when it is sent again.
bool says_nothing_of_the_batch(const Error& error) {
  return error.code == Code::kInternal || error.code == Code::kCancelled ||
         error.code == Code::kUnavailable || error.reason == "OUT_OF_MEMORY" ||
         error.reason == exec::kMemoryBudget;
}

}  // namespace

Error taken_over() {
  return {Code::kAborted, "the producer was opened by another call, which goes on for it",
          "PRODUCER_TAKEN_OVER"};
}

void ProducerSession::take_over() {
  if (producer_.call.exchange(call_.id) != nullptr) scene_.events().notify();
}

void ProducerSession::leave() {
  const void* mine = call_.id;
  producer_.call.compare_exchange_strong(mine, nullptr);
}

Status ProducerSession::apply_some(std::deque<UpdateBatch>& batches) {
  if (scene_.removed()) return scene_.removed_error();
  if (producer_.call.load() != call_.id) return taken_over();
  if (call_.latest_wins && alone_ == 0 && apply_together(batches)) return {};
  if (alone_ > 0) --alone_;
  return apply_first(batches);
}

scenegraph::ApplyOptions ProducerSession::options(const std::deque<UpdateBatch>& batches,
                                                  std::size_t count, const Taken& taken) const {
  return {.before_publish =
              [&batches, count, taken](const scenegraph::Applied& next) {
                for (std::size_t i = 0; i < count; ++i)
                  taken->outcomes.push_back({batches[i].sequence, batches[i].bytes, next});
              },
          .cancelled = call_.cancelled};
}

scenes::SceneWrite ProducerSession::write(const UpdateBatch& first, std::size_t count,
                                          const Taken& taken) const {
  scenes::SceneWrite write;
  write.producer = &producer_;
  write.first_sequence = first.sequence;
  write.batches = count;
  write.relaxed = call_.relaxed;
  write.answer = [answer = call_.answer, taken](const Result<scenes::Durability>& kept) {
    if (!kept) return answer(kept.error());
    taken->durability = *kept;
    answer(std::move(*taken));
  };
  return write;
}

/// Returns false and changes nothing if fewer than two batches can be merged, or if the merged
/// batch fails.
bool ProducerSession::apply_together(std::deque<UpdateBatch>& batches) {
  const std::size_t count = count_to_coalesce(batches);
  if (count < 2) return false;
  const auto taken = std::make_shared<Answered>();
  coalesced_ += count - 1;  // before the batches are answered
  if (!scene_.apply(coalesce(batches, count), compute_, options(batches, count, taken),
                    write(batches.front(), count, taken))) {
    coalesced_ -= count - 1;
    alone_ = count;
    return false;
  }
  batches.erase(batches.begin(), batches.begin() + static_cast<std::ptrdiff_t>(count));
  return true;
}

Status ProducerSession::apply_first(std::deque<UpdateBatch>& batches) {
  UpdateBatch& batch = batches.front();
  const auto taken = std::make_shared<Answered>();
  std::optional<Error> rejected = batch.bad;
  if (!rejected) {
    const auto applied = scene_.apply(std::move(batch.updates), compute_,
                                      options(batches, 1, taken), write(batch, 1, taken));
    if (!applied && says_nothing_of_the_batch(applied.error())) return applied.error();
    if (!applied) rejected = applied.error();
  }
  if (rejected) {
    taken->outcomes.assign(1, {batch.sequence, batch.bytes, *rejected});
    if (Status recorded = scene_.record_rejected(compute_, write(batch, 1, taken)); !recorded)
      return recorded;
  }
  batches.pop_front();
  return {};
}

}  // namespace sightline::server::updates
