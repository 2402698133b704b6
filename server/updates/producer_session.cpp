// Applies the batches of one producer.
#include "server/updates/producer_session.h"

#include <utility>

#include "server/updates/coalesce.h"

namespace sightline::server::updates {
namespace {

/// Whether the server failed or the call ended. The batch may succeed when it is sent again.
bool says_nothing_of_the_batch(const Error& error) {
  return error.code == Code::kInternal || error.code == Code::kCancelled ||
         error.reason == "OUT_OF_MEMORY" || error.reason == exec::kMemoryBudget;
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

Result<std::vector<BatchOutcome>> ProducerSession::apply_some(std::deque<UpdateBatch>& batches) {
  if (scene_.removed()) return scene_.removed_error();
  if (producer_.call.load() != call_.id) return taken_over();
  std::vector<BatchOutcome> outcomes;
  if (call_.latest_wins && alone_ == 0 && apply_together(batches, outcomes)) return outcomes;
  if (alone_ > 0) --alone_;
  if (const Status done = apply_first(batches, outcomes); !done) return done.error();
  return outcomes;
}

scenegraph::ApplyOptions ProducerSession::options(
    std::function<void(const scenegraph::Applied&)> record) const {
  return {.before_publish = std::move(record), .cancelled = call_.cancelled};
}

/// Returns false and changes nothing if fewer than two batches can be merged, or if the merged
/// batch fails.
bool ProducerSession::apply_together(std::deque<UpdateBatch>& batches,
                                     std::vector<BatchOutcome>& outcomes) {
  const std::size_t count = count_to_coalesce(batches);
  if (count < 2) return false;
  Puts puts;
  const auto record = [&](const scenegraph::Applied& next) {
    puts = prepare(batches, count, next, outcomes);
  };
  if (!scene_.apply(coalesce(batches, count), compute_, options(record))) {
    alone_ = count;
    return false;
  }
  coalesced_ += count - 1;
  commit(batches, std::move(puts));
  return true;
}

Status ProducerSession::apply_first(std::deque<UpdateBatch>& batches,
                                    std::vector<BatchOutcome>& outcomes) {
  UpdateBatch& batch = batches.front();
  Puts puts;
  const auto record = [&](const Result<scenegraph::Applied>& result) {
    puts = prepare(batches, 1, result, outcomes);
  };
  if (batch.bad) {
    record(*batch.bad);
  } else {
    const auto applied = scene_.apply(std::move(batch.updates), compute_, options(record));
    if (!applied && says_nothing_of_the_batch(applied.error())) return applied.error();
    if (!applied) record(applied.error());
  }
  commit(batches, std::move(puts));
  return {};
}

/// Makes the outcomes of the first batches, and what commit() needs.
ProducerSession::Puts ProducerSession::prepare(const std::deque<UpdateBatch>& batches,
                                               std::size_t count,
                                               const Result<scenegraph::Applied>& result,
                                               std::vector<BatchOutcome>& outcomes) {
  Puts puts;
  for (std::size_t i = 0; i < count; ++i) {
    const UpdateBatch& batch = batches[i];
    auto nodes = result ? result->nodes : std::vector<scenegraph::model::NodeId>();
    auto charge =
        scene_.memory().record(exec::Held::kLogs, nodes.size() * sizeof(scenegraph::model::NodeId));
    puts.push_back({batch.sequence, std::move(nodes), std::move(charge)});
    outcomes.push_back({batch.sequence, batch.bytes, result});
  }
  producer_.put.reserve_more(count);
  return puts;
}

/// Records the first batches and removes them.
void ProducerSession::commit(std::deque<UpdateBatch>& batches, Puts puts) noexcept {
  for (scenes::Producer::Put& put : puts) {
    producer_.commit(std::move(put));
    batches.pop_front();
  }
}

}  // namespace sightline::server::updates
