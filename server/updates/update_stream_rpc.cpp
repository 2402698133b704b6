// SceneService.StreamUpdates: the batches of one producer over one call.
#include "server/updates/update_stream_rpc.h"

#include <fmt/format.h>

#include <mutex>
#include <optional>
#include <utility>

#include "server/exec/rpc_log.h"
#include "server/exec/rpc_status.h"
#include "server/updates/producer_session.h"
#include "server/updates/update_answers.h"

namespace sightline::server::updates {
namespace {

Error invalid(std::string message, std::string reason) {
  return {Code::kInvalidArgument, std::move(message), std::move(reason)};
}

Error cancelled() { return {Code::kCancelled, "the call was cancelled", "CANCELLED"}; }

/// Three things go on at a time: reading, applying what has come, and writing what came of it. Each
/// calls advance() when it has got somewhere, which sets going whatever can go. The window bounds
/// all that is kept: a batch counts until its answer is written.
class UpdateStream final
    : public grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse> {
 public:
  explicit UpdateStream(const scenes::Services& services)
      : services_(services), batches_(services.blobs, services.admission) {}

  void start() {
    const Status entered = services_.update_streams.enter(this, [this] {
      advance([this] { end_after_answers(services_.update_streams.stopped_error()); });
    });
    advance([&] {
      starting_ = false;
      if (!entered) end_now(entered.error());
    });
  }

  void OnReadDone(bool ok) override {
    // Only this thread reads: what has come is looked at outside of the lock.
    Status taken;
    if (ok) taken = exec::to_status([this] { return take(); });
    advance([&] {
      reading_ = false;
      if (!ok) return end_after_answers({});  // the client has closed its side, or is gone
      if (!taken) return end_after_answers(taken);
      if (ending_) return;
      if (came_) {
        window_bytes_ += came_->bytes;
        ++window_;
        waiting_.push_back(*std::exchange(came_, std::nullopt));
      } else if (std::exchange(repeated_, false)) {
        answers_.ack(answered_, scene_->token(revision_), coalesced_, {}, 0);
      }
    });
  }

  void OnWriteDone(bool ok) override {
    advance([&] {
      writing_ = false;
      window_ -= std::exchange(being_written_, 0);
      if (!ok) end_now(Error{Code::kCancelled, "the answer could not be written", "CANCELLED"});
    });
  }

  void OnCancel() override {
    advance([this] { end_now(cancelled()); });
  }

  void OnDone() override {
    services_.compute.enqueue([this] {
      services_.update_streams.leave(this);
      if (scene_ == nullptr) return delete this;
      if (listener_ != 0) scene_->events().unsubscribe(listener_);
      // In turn, after all that this call has left there.
      scene_->write_queue().post(services_.compute, [this] {
        if (session_) session_->leave();
        delete this;
      });
    });
  }

 private:
  /// Errors end the call.
  Status take() {
    if (request_.has_open()) return scene_ == nullptr ? open(request_.open()) : opened_twice();
    if (!request_.has_batch()) return invalid("a message says nothing", "EMPTY_MESSAGE");
    if (scene_ == nullptr) return invalid("the first message must open a producer", "NOT_OPENED");
    const auto came = batches_.accept(request_.batch());
    if (!came) return came.error();
    if (*came == UpdateBatches::Received::kBatch) came_ = batches_.batch();
    repeated_ = *came == UpdateBatches::Received::kRepeat;
    return {};
  }

  static Status opened_twice() {
    return invalid("only the first message may open a producer", "OPENED_TWICE");
  }

  Status open(const v1::OpenProducer& open) {
    if (Status good = scenes::check_producer_name(open.producer()); !good) return good;
    auto scene = services_.find(open.scene());
    if (!scene) return scene.error();
    {
      const std::lock_guard lock(mutex_);
      scene_ = std::move(*scene);
      working_ = true;
    }
    scene_->write_queue().post(
        services_.compute, [this, name = open.producer(), latest_wins = open.latest_wins()] {
          const Status opened = exec::to_status([&] { return enter_scene(name, latest_wins); });
          advance([&] {
            working_ = false;
            if (!opened) return end_now(opened);
            if (abandoned_) return;
            opened_ = true;
            answers_.opened(*producer_, kUpdateWindow, scene_->token(revision_));
          });
        });
    return {};
  }

  /// In turn.
  Status enter_scene(const std::string& name, bool latest_wins) {
    if (scene_->removed()) return scene_->removed_error();
    const auto producer = scene_->producers().open(name);
    if (!producer) return producer.error();
    producer_ = *producer;
    session_.emplace(*scene_, *producer_, this, services_.compute, latest_wins);
    session_->take_over();
    batches_.begin(producer_->last_committed);
    answered_ = producer_->last_committed;
    revision_ = scene_->snapshot()->revision();
    listener_ = scene_->events().subscribe([this] { on_scene_event(); });
    on_scene_event();  // at what has happened before
    return {};
  }

  /// Something has happened to the scene.
  void on_scene_event() {
    if (scene_->removed()) return advance([this] { end_now(scene_->removed_error()); });
    if (producer_->call.load() != this) advance([this] { end_now(taken_over()); });
  }

  /// In turn: applies what waits.
  void work() {
    std::deque<UpdateBatch> batches;
    {
      const std::lock_guard lock(mutex_);
      batches.swap(waiting_);
    }
    for (bool go = true; go;) {
      std::vector<BatchOutcome> outcomes;
      const Status applied = exec::to_status([&]() -> Status {
        if (batches.empty()) return {};  // forgotten meanwhile
        auto some = session_->apply_some(batches);
        if (!some) return some.error();
        outcomes = std::move(*some);
        return {};
      });
      advance([&] {
        answer(outcomes);
        if (!applied) end_now(applied);
        go = !abandoned_ && !batches.empty();
        working_ = go;
      });
    }
  }

  // Those below hold the mutex.

  void answer(const std::vector<BatchOutcome>& outcomes) {
    coalesced_ = session_->coalesced();
    for (const BatchOutcome& outcome : outcomes) {
      window_bytes_ -= outcome.bytes;
      answered_ = outcome.sequence;
      if (outcome.applied) {
        revision_ = outcome.applied->revision;
        answers_.ack(answered_, scene_->token(revision_), coalesced_, outcome.applied->nodes);
      } else {
        answers_.reject(answered_, outcome.applied.error());
      }
    }
    if (abandoned_) answers_.clear();
  }

  /// All that has come is applied and answered before.
  void end_after_answers(const Status& status) {
    if (!ending_) ending_ = status;
  }

  /// What has come and is not in work is forgotten.
  void end_now(const Status& status) {
    if (!ending_ || (ending_->ok() && !abandoned_)) ending_ = status;
    abandoned_ = true;
    waiting_.clear();
    answers_.clear();
  }

  bool may_read() const {
    if (starting_ || reading_ || ending_ || window_ >= kUpdateWindow) return false;
    if (!opened_) return scene_ == nullptr;
    // A batch that has come in part must be able to come whole.
    const bool alone = waiting_.empty() && !working_;
    return alone || window_bytes_ + batches_.bytes() < kUpdateWindowBytes;
  }

  bool may_end() const {
    return ending_ && !starting_ && !working_ && !writing_ && waiting_.empty() && answers_.empty();
  }

  /// Sets going what can go after the change. This may be gone when it returns.
  template <class Change>
  void advance(const Change& change) {
    grpc::Status status;
    {
      const std::lock_guard lock(mutex_);
      change();
      if (ended_) return;
      if (may_read()) {
        reading_ = true;
        StartRead(&request_);
      }
      if (!waiting_.empty() && !working_) {
        working_ = true;
        scene_->write_queue().post(services_.compute, [this] { work(); });
      }
      if (!answers_.empty() && !writing_) {
        writing_ = true;
        being_written_ = answers_.pop(reply_);
        StartWrite(&reply_);
      }
      if (!may_end()) return;
      ended_ = true;
      status = exec::to_grpc(*ending_);
      exec::log_rpc("StreamUpdates", status, begun_,
                    fmt::format("up_to={} coalesced={}", answered_, coalesced_));
    }
    Finish(status);
  }

  const exec::LogClock::time_point begun_ = exec::LogClock::now();
  const scenes::Services& services_;
  v1::StreamUpdatesRequest request_;
  UpdateBatches batches_;  // while reading
  std::optional<UpdateBatch> came_;
  bool repeated_ = false;
  // Written once, before the producer is opened.
  std::shared_ptr<scenes::StoredScene> scene_;
  scenes::Producer* producer_ = nullptr;
  std::uint64_t listener_ = 0;
  std::optional<ProducerSession> session_;  // in turn

  std::mutex mutex_;  // of all below
  bool starting_ = true, opened_ = false;
  bool reading_ = false, working_ = false, writing_ = false;  // under way
  std::deque<UpdateBatch> waiting_;
  UpdateAnswers answers_;
  v1::StreamUpdatesResponse reply_;
  std::size_t being_written_ = 0;  // batches that the reply answers
  std::size_t window_ = 0;         // batches whose answers are not written
  std::size_t window_bytes_ = 0;   // of batches that are not applied
  std::uint64_t answered_ = 0, revision_ = 0, coalesced_ = 0;
  std::optional<Status> ending_;
  bool abandoned_ = false, ended_ = false;
};

}  // namespace

grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>* start_update_stream(
    const scenes::Services& services) {
  auto* stream = new UpdateStream(services);
  stream->start();
  return stream;
}

}  // namespace sightline::server::updates
