// Applies the batches of one producer.
#include "server/updates/producer_session.h"

#include <utility>

#include "server/scenes/write_errors.h"
#include "server/updates/coalesce.h"

namespace sightline::server::updates {
namespace {

/// The first batches, whose outcomes are not known yet.
std::shared_ptr<Answered> take(const std::deque<UpdateBatch>& batches, std::size_t count) {
  auto taken = std::make_shared<Answered>();
  for (std::size_t i = 0; i < count; ++i)
    taken->outcomes.push_back({batches[i].sequence, batches[i].bytes, scenegraph::Applied{}});
  return taken;
}

void set_all(Answered& taken, const Result<scenegraph::Applied>& result) {
  for (BatchOutcome& outcome : taken.outcomes) outcome.applied = result;
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
  if (alone_ > 0 && !caught_up_) --alone_;
  return apply_first(batches);
}

scenegraph::ApplyOptions ProducerSession::options(const Taken& taken) const {
  return {.before_publish = [taken](const scenegraph::Applied& next) { set_all(*taken, next); },
          .cancelled = call_.cancelled};
}

scenes::SceneWrite ProducerSession::write(const Taken& taken) const {
  scenes::SceneWrite write;
  write.producer = &producer_;
  write.first_sequence = taken->outcomes.front().sequence;
  write.batches = taken->outcomes.size();
  write.relaxed = call_.relaxed;
  write.answer = [answer = call_.answer, taken](const Result<scenes::Durability>& kept) {
    if (!kept) return answer(kept.error());
    taken->durability = *kept;
    answer(std::move(*taken));
  };
  write.rejected = [taken](const Error& error) { set_all(*taken, error); };
  write.repeated = [taken](const scenegraph::Applied& earlier) { set_all(*taken, earlier); };
  return write;
}

/// Returns false and changes nothing if fewer than two batches can be merged, or if the merged
/// batch fails.
bool ProducerSession::apply_together(std::deque<UpdateBatch>& batches) {
  const std::size_t count = count_to_coalesce(batches);
  if (count < 2) return false;
  const Taken taken = take(batches, count);
  coalesced_ += count - 1;  // before the batches are answered
  if (!scene_.apply(coalesce(batches, count), compute_, options(taken), write(taken))) {
    coalesced_ -= count - 1;
    alone_ = count;
    return false;
  }
  batches.erase(batches.begin(), batches.begin() + static_cast<std::ptrdiff_t>(count));
  return true;
}

Status ProducerSession::apply_first(std::deque<UpdateBatch>& batches) {
  UpdateBatch& batch = batches.front();
  const Taken taken = take(batches, 1);
  std::optional<Error> invalid = batch.bad;
  if (!invalid) {
    const auto applied = scene_.try_apply(batch.updates, compute_, options(taken), write(taken));
    if (!applied && scenes::says_nothing_of_the_batch(applied.error())) return applied.error();
    if (!applied) invalid = applied.error();
    awaits_others_ = invalid && scene_.follower() != nullptr && !caught_up_;
    if (awaits_others_) return {};
  }
  caught_up_ = false;
  if (invalid) {
    set_all(*taken, *invalid);
    if (Status recorded = scene_.record_rejected(compute_, write(taken)); !recorded)
      return recorded;
  }
  batches.pop_front();
  return {};
}

}  // namespace sightline::server::updates
