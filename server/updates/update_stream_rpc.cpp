// SceneService.StreamUpdates: the batches of one producer over one call.
#include "server/updates/update_stream_rpc.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "server/exec/call_context.h"
#include "server/exec/malformed.h"
#include "server/exec/rpc_status.h"
#include "server/updates/producer_messages.h"
#include "server/updates/producer_session.h"

namespace sightline::server::updates {
namespace {

/// The call as a whole. States only follow each other in this order; some may be left out.
enum class State : std::uint8_t {
  kAwaitingOpen,  ///< The first message has not arrived.
  kOpening,       ///< The write queue opens the producer.
  kOpen,          ///< Batches are read, applied and answered.
  kDraining,      ///< Reads no more. Ends when every batch that was read is applied and answered.
  kAborting,      ///< Drops waiting batches and answers. Ends when no operation runs.
  kEnded,         ///< Finish() has been called.
};

/// Up to three operations run at a time: a read, a task on the scene's write queue, and a write.
/// Each reports its end through advance(), which starts what the state then allows. The window
/// bounds the memory of the call: a batch counts until its answer is written.
class UpdateStream final
    : public grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse> {
 public:
  UpdateStream(const scenes::Services& services, grpc::CallbackServerContext& context)
      : services_(services),
        context_(context),
        caller_(exec::caller_of(context)),
        batches_(services.blobs, caller_, services.admission, services.batch_admission,
                 services.quotas) {}

  void start() {
    const Status entered = services_.update_streams.enter(
        this, caller_,
        {.on_stop =
             [this] {
               advance(
                   [this] { enter(State::kDraining, services_.update_streams.stopped_error()); });
             },
         .on_late = [this] { advance([this] { enter(State::kDraining, late()); }); }},
        &peer_);
    advance([&] {
      working_ = false;
      if (!entered) enter(State::kAborting, entered.error());
    });
  }

  void OnReadDone(bool ok) override {
    peer_.end();
    // No other thread reads, so the message is decoded without the lock.
    Received received = Received::kPart;
    const Status accepted =
        ok ? exec::to_status([&] { return accept(received); }) : exec::end_of_reads(request_);
    advance([&] {
      reading_ = false;
      if (!ok || !accepted) return enter(State::kDraining, accepted);
      if (state_ >= State::kDraining) return;
      if (received == Received::kBatch) return add_batch(batches_.batch());
      if (received == Received::kRepeat)
        answers_.ack({answered_, scene_->token(revision_), coalesced_, durability_, 0}, {});
    });
  }

  void OnWriteDone(bool ok) override {
    advance([&] {
      writing_ = false;
      held_.reset();
      window_ -= std::exchange(being_written_, 0);
      if (!ok) {
        enter(State::kAborting,
              Error{Code::kCancelled, "the answer could not be written", "CANCELLED"});
      }
    });
  }

  void OnCancel() override {
    advance([this] {
      enter(State::kAborting, Error{Code::kCancelled, "the call was cancelled", "CANCELLED"});
    });
  }

  void OnDone() override {
    held_.reset();                         // before the context goes
    services_.update_streams.leave(this);  // now: the client may open the next call at once
    services_.compute.enqueue_background([this] {
      if (scene_ == nullptr) return delete this;
      if (listener_ != 0) scene_->events().unsubscribe(listener_);
      // This runs after all tasks that this call has posted to the write queue, and after all
      // answers.
      scene_->write_queue().post(services_.compute, [this] {
        if (session_) session_->leave();
        scene_->when_answered([this] { delete this; });
      });
    });
  }

 private:
  using Received = UpdateBatches::Received;

  /// The error of a call whose client has sent nothing for too long.
  static Error late() {
    return {Code::kAborted,
            "the stream was idle, or a batch did not go on, and its place is needed or its time is "
            "over: open it again",
            "STREAM_IDLE"};
  }

  /// Handles request_ and sets what it completes. Errors end the call.
  Status accept(Received& received) {
    if (request_.has_open()) {
      if (scene_ != nullptr)
        return exec::invalid_argument("only the first message may open a producer", "OPENED_TWICE");
      return open(request_.open());
    }
    if (!request_.has_batch())
      return exec::invalid_argument("a message says nothing", "EMPTY_MESSAGE");
    if (scene_ == nullptr)
      return exec::invalid_argument("the first message must open a producer", "NOT_OPENED");
    const auto completed = batches_.accept(request_.batch());
    if (!completed) return completed.error();
    received = *completed;
    return {};
  }

  Status open(const v1::OpenProducer& open) {
    if (Status allowed = exec::check_role(context_, exec::Role::kWrite, open.scene()); !allowed)
      return allowed;
    if (Status good = scenes::check_producer_name(open.producer()); !good) return good;
    if (!v1::Durability_IsValid(open.durability())) {
      return exec::invalid_argument(
          fmt::format("durability {} is not known", static_cast<int>(open.durability())),
          "UNKNOWN_DURABILITY");
    }
    auto scene = services_.find(open.scene());
    if (!scene) return scene.error();
    {
      const std::lock_guard lock(mutex_);
      scene_ = std::move(*scene);
      enter(State::kOpening, {});
      working_ = true;
    }
    scene_->write_queue().post(services_.compute, [this, open] {
      const Status begun = exec::to_status([&] { return begin_session(open); });
      if (!begun) return opened(begun);
      // The producer may have batches that are not answered yet.
      scene_->when_committed([this](const Status& kept) {
        scenes::SceneFollower* const follower = scene_->follower();
        if (!kept || follower == nullptr) return opened(kept);
        follower->look_up(*producer_, services_.compute, [this](const Status& s) { opened(s); });
      });
    });
    return {};
  }

  /// Runs on the write queue.
  Status begin_session(const v1::OpenProducer& open) {
    if (Status loaded = scene_->load(services_.compute); !loaded) return loaded;
    if (scene_->removed()) return scene_->removed_error();
    const auto producer = scene_->producers().open(open.producer());
    if (!producer) return producer.error();
    producer_ = *producer;
    const bool relaxed =
        open.durability() == v1::DURABILITY_RELAXED && scene_->follower() == nullptr;
    durability_ = relaxed || !scene_->is_kept() ? scenes::Durability::kRelaxed
                                                : scenes::Durability::kCommitted;
    session_.emplace(*scene_, *producer_,
                     ProducerSession::Call{
                         .id = this,
                         .cancelled = &aborting_,
                         .latest_wins = open.latest_wins(),
                         .relaxed = relaxed,
                         .answer = [this](const Result<Answered>& result) { answered(result); }},
                     services_.compute);
    session_->take_over();
    return {};
  }

  /// Runs on the write queue.
  void opened(const Status& begun) {
    const Status opened = exec::to_status([&]() -> Status {
      if (!begun) return begun;
      batches_.begin(producer_->last_committed);
      answered_ = producer_->last_committed;
      revision_ = scene_->snapshot()->revision();
      listener_ = scene_->events().subscribe([this] { on_scene_event(); });
      on_scene_event();  // for an event before the subscription
      return {};
    });
    advance([&] {
      working_ = false;
      if (!opened) return enter(State::kAborting, opened);
      if (state_ >= State::kAborting) return;
      enter(State::kOpen, {});
      answers_.opened(*producer_, kUpdateWindow, scene_->token(revision_));
    });
  }

  void on_scene_event() {
    if (scene_->removed())
      return advance([this] { enter(State::kAborting, scene_->removed_error()); });
    if (producer_->call.load() != this) advance([this] { enter(State::kAborting, taken_over()); });
  }

  /// Applies the waiting batches, on the write queue.
  void apply_waiting() {
    std::deque<UpdateBatch> batches;
    {
      const std::lock_guard lock(mutex_);
      batches.swap(waiting_);
    }
    for (bool more = true; more;) {
      const Status applied = exec::to_status([&]() -> Status {
        if (batches.empty()) return {};  // an abort has dropped them
        return session_->apply_some(batches);
      });
      if (applied && session_->awaits_others()) return catch_up(std::move(batches));
      advance([&] {
        if (!applied) enter(State::kAborting, applied);
        more = state_ < State::kAborting && !batches.empty();
        working_ = more;
      });
    }
  }

  /// Continues with the batches, on the write queue, when what other servers have committed is
  /// known.
  void catch_up(std::deque<UpdateBatch> batches) {
    advance([&] {
      std::ranges::move(waiting_, std::back_inserter(batches));
      if (state_ < State::kAborting) waiting_.swap(batches);
    });
    scene_->follower()->when_caught_up(services_.compute, [this](const Status& read) {
      session_->caught_up();
      if (!read) advance([&] { enter(State::kAborting, read); });
      apply_waiting();
    });
  }

  /// Runs on the write queue, also after the call has ended.
  void answered(const Result<Answered>& result) {
    advance([&] {
      if (!result) return enter(State::kAborting, result.error());
      answer(*result);
    });
  }

  // The members below are called with the mutex held.

  /// The only function that changes state_. A state that is already reached or passed is ignored.
  /// `status` is what the call ends with: that of the first change to kDraining or kAborting,
  /// except that an abort replaces the OK of a client that closed its side.
  void enter(State next, const Status& status) {
    if (next <= state_) return;
    if (state_ < State::kDraining || status_.ok()) status_ = status;
    state_ = next;
    if (state_ != State::kAborting) return;
    aborting_.store(true, std::memory_order_relaxed);
    waiting_.clear();
    answers_.clear();
  }

  void add_batch(UpdateBatch batch) {
    window_bytes_ += batch.bytes;
    ++window_;
    waiting_.push_back(std::move(batch));
  }

  void answer(const Answered& result) {
    coalesced_ = session_->coalesced();
    for (const BatchOutcome& outcome : result.outcomes) {
      window_bytes_ -= outcome.bytes;
      answered_ = outcome.sequence;
      if (outcome.applied) {
        revision_ = outcome.applied->revision;
        answers_.ack({answered_, scene_->token(revision_), coalesced_, result.durability},
                     outcome.applied->nodes);
      } else {
        answers_.reject(answered_, outcome.applied.error());
      }
    }
    if (state_ >= State::kAborting) answers_.clear();
  }

  void write() {
    const std::size_t answered = answers_.pop(reply_);
    auto held = services_.unread.hold(context_, caller_, 2 * reply_.ByteSizeLong());
    if (!held) return enter(State::kAborting, held.error());
    held_ = std::move(*held);
    writing_ = true;
    being_written_ = answered;
    StartWrite(&reply_);
  }

  bool may_read() const {
    if (reading_) return false;
    if (state_ == State::kAwaitingOpen) return !working_;
    if (state_ != State::kOpen || window_ >= kUpdateWindow) return false;
    // A batch of which a part has arrived must be able to arrive completely.
    const bool alone = waiting_.empty() && !working_;
    return alone || window_bytes_ + batches_.bytes() < kUpdateWindowBytes;
  }

  bool may_end() const {
    const bool all_answered = window_ == 0 || state_ == State::kAborting;
    return (state_ == State::kDraining || state_ == State::kAborting) && !working_ && !writing_ &&
           waiting_.empty() && answers_.empty() && all_answered;
  }

  /// Makes the change, then starts every operation that may run, or ends the call. The call may be
  /// deleted before this returns.
  template <class Change>
  void advance(const Change& change) {
    grpc::Status status;
    {
      const std::lock_guard lock(mutex_);
      change();
      if (may_read()) {
        reading_ = true;
        exec::before_read(request_);
        if (batches_.open()) {
          peer_.begin(kBatchTimeout);
        } else {
          peer_.begin(exec::kIdleStream);
        }
        StartRead(&request_);
      }
      if (!waiting_.empty() && !working_) {
        working_ = true;
        scene_->write_queue().post(services_.compute, [this] { apply_waiting(); });
      }
      if (!answers_.empty() && !writing_) write();
      if (!may_end()) return;
      enter(State::kEnded, status_);
      status = exec::to_grpc(status_);
      exec::log_rpc("StreamUpdates", context_, status, begun_,
                    fmt::format("up_to={} coalesced={}", answered_, coalesced_));
    }
    Finish(status);
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  exec::PeerWait peer_;
  v1::StreamUpdatesRequest request_;
  UpdateBatches batches_;  // used by the read
  // Written once, before the producer is open.
  std::shared_ptr<scenes::StoredScene> scene_;
  scenes::Producer* producer_ = nullptr;
  std::uint64_t listener_ = 0;
  std::optional<ProducerSession> session_;                        // used on the write queue
  std::atomic<bool> aborting_{false};                             // the state has reached kAborting
  scenes::Durability durability_ = scenes::Durability::kRelaxed;  // what repeated batches have

  std::mutex mutex_;  // protects all members below
  State state_ = State::kAwaitingOpen;
  Status status_;  // from kDraining on
  bool reading_ = false, writing_ = false;
  bool working_ = true;  // a task runs on the write queue; at first, start()
  std::deque<UpdateBatch> waiting_;
  UpdateAnswers answers_;
  v1::StreamUpdatesResponse reply_;
  std::unique_ptr<exec::UnreadReplies::Held> held_;  // while reply_ is written
  std::size_t being_written_ = 0;                    // batches that reply_ answers
  std::size_t window_ = 0;                           // batches whose answers are not written
  std::size_t window_bytes_ = 0;                     // batches that are not applied
  std::uint64_t answered_ = 0, revision_ = 0, coalesced_ = 0;
};

}  // namespace

grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>* start_update_stream(
    const scenes::Services& services, grpc::CallbackServerContext& context) {
  auto* stream = new UpdateStream(services, context);
  stream->start();
  return stream;
}

}  // namespace sightline::server::updates
