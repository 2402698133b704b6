// One thread opens the call and reads answers. While a call is open, a second thread writes
// batches.
#include "client/calls/update_stream_worker.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/calls/apply.h"
#include "client/calls/connection.h"

namespace sightline::client::calls {
namespace {

constexpr std::size_t kRejectsKept = 1024;

StreamAck::Put decode(const v1::PutNodes& put) {
  return {put.sequence(), {put.nodes().begin(), put.nodes().end()}};
}

Error closed() { return {Code::kFailedPrecondition, "the stream of updates is closed", {}}; }

}  // namespace

UpdateStreamWorker::UpdateStreamWorker(std::unique_ptr<v1::SceneService::Stub> stub,
                                       const std::string& scene, const std::string& producer,
                                       UpdateStreamOptions options)
    : stub_(std::move(stub)), options_(std::move(options)), backoff_(options_.attempts) {
  v1::OpenProducer& open = *opening_.mutable_open();
  open.set_scene(scene);
  open.set_producer(producer);
  open.set_latest_wins(options_.latest_wins);
  open.set_durability(options_.relaxed ? v1::DURABILITY_RELAXED : v1::DURABILITY_COMMITTED);
  thread_ = std::thread([this] { run(); });
}

UpdateStreamWorker::~UpdateStreamWorker() {
  {
    const std::lock_guard lock(mutex_);
    abandoned_ = true;
    if (context_ != nullptr) context_->TryCancel();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Status UpdateStreamWorker::open(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, timeout, [this] { return opened_ || ended_; })) {
    return Error{Code::kDeadlineExceeded,
                 fmt::format("no stream of updates was opened in {} ms", timeout.count()),
                 {}};
  }
  return failed_ ? Status(*failed_) : Status();
}

Result<std::optional<std::uint64_t>> UpdateStreamWorker::enqueue(Messages messages, bool waits) {
  std::unique_lock lock(mutex_);
  const auto may_enqueue = [this] {
    return ended_ || closing_ || unanswered_.size() < state_.window;
  };
  if (waits) changed_.wait(lock, may_enqueue);
  if (failed_) return *failed_;
  if (ended_ || closing_) return closed();
  if (!may_enqueue()) return std::optional<std::uint64_t>();
  const std::uint64_t sequence = ++state_.last_sent;
  set_sequence(sequence, messages);
  unanswered_.push_back({sequence, std::make_shared<const Messages>(std::move(messages))});
  lock.unlock();
  changed_.notify_all();
  return std::optional(sequence);
}

Status UpdateStreamWorker::wait(std::uint64_t sequence) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return ended_ || state_.last_answered >= sequence; });
  if (const auto reject = rejects_.find(sequence); reject != rejects_.end()) return reject->second;
  if (state_.last_answered >= sequence) return {};
  return failed_ ? *failed_ : closed();
}

Status UpdateStreamWorker::flush() {
  std::unique_lock lock(mutex_);
  const std::uint64_t sequence = state_.last_sent;
  changed_.wait(lock, [&] { return ended_ || state_.last_answered >= sequence; });
  if (failed_) return *failed_;
  return state_.last_answered >= sequence ? Status() : Status(closed());
}

Status UpdateStreamWorker::close() {
  {
    std::unique_lock lock(mutex_);
    closing_ = true;
    changed_.notify_all();
    changed_.wait(lock, [this] { return ended_; });
  }
  return failed_ ? Status(*failed_) : Status();
}

UpdateStreamState UpdateStreamWorker::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void UpdateStreamWorker::run() {
  while (true) {
    grpc::ClientContext context;
    set_route(context, opening_.open().scene());
    {
      const std::lock_guard lock(mutex_);
      context_ = &context;
      if (abandoned_) context.TryCancel();
    }
    const Status ended = run_call(context);
    std::unique_lock lock(mutex_);
    context_ = nullptr;
    if (!should_retry(ended)) {
      ended_ = true;
      lock.unlock();
      changed_.notify_all();
      return;
    }
    ++state_.reconnects;
    changed_.wait_for(lock, pause_before_next_, [this] { return abandoned_; });
  }
}

// Sets failed_ if there is no further attempt and the stream was not closed.
bool UpdateStreamWorker::should_retry(const Status& ended) {
  if (is_done()) return false;
  if (abandoned_) {
    failed_ = closed();
    return false;
  }
  // If the server ended the call without an error before all was answered, the call counts as
  // broken.
  const Error error = ended
                          ? Error{Code::kUnavailable, "the server ended the stream of updates", {}}
                          : ended.error();
  const bool is_transient = is_broken_connection(error.code) || error.code == Code::kCancelled;
  if (std::exchange(progressed_, false)) {
    backoff_.reset();
    retries_.progressed();
  }
  if (const auto pause = retries_.pause(last_call_); pause && !failed_) {
    pause_before_next_ = *pause;
    return true;
  }
  if (opened_ && !failed_ && is_transient && backoff_.again()) {
    pause_before_next_ = backoff_.pause();
    return true;
  }
  if (!failed_) failed_ = error;
  return false;
}

Status UpdateStreamWorker::run_call(grpc::ClientContext& context) {
  const std::unique_ptr<Call> call = stub_->StreamUpdates(&context);
  v1::StreamUpdatesResponse response;
  if (!call->Write(opening_) || !call->Read(&response)) {
    last_call_ = call->Finish();
    return last_call_.ok() ? Status() : Status(rpc_error(last_call_));
  }
  if (Status resumed = resume(response); !resumed) {
    fail(resumed.error());
    context.TryCancel();
    last_call_ = call->Finish();
    return resumed;
  }
  std::thread writing([&] { write_batches(*call); });
  while (call->Read(&response)) receive(response);
  {
    const std::lock_guard lock(mutex_);
    connected_ = false;
  }
  changed_.notify_all();
  writing.join();
  last_call_ = call->Finish();
  return last_call_.ok() ? Status() : Status(rpc_error(last_call_));
}

// The server says which batches it has committed. All later ones are sent again.
Status UpdateStreamWorker::resume(const v1::StreamUpdatesResponse& first) {
  if (!first.has_opened())
    return Error{Code::kInternal, "the server answered before it opened a stream of updates", {}};
  const v1::ProducerOpened& opened = first.opened();
  const std::uint64_t committed = opened.last_committed();
  std::unique_lock lock(mutex_);
  if (!opened_) {
    state_.last_sent = state_.last_answered = committed;
  } else if (committed < state_.last_answered || committed > state_.last_sent) {
    return Error{Code::kAborted,
                 fmt::format("the server has {} batches of this producer, of "
                             "{} that were sent and "
                             "{} that it answered: the scene was made anew, or "
                             "somebody else sends "
                             "under the same name",
                             committed, state_.last_sent, state_.last_answered),
                 "PRODUCER_CHANGED"};
  }
  opened_ = connected_ = true;
  progressed_ = false;
  state_.window = std::max(opened.window(), 1U);
  coalesced_in_calls_ = state_.coalesced;
  next_to_write_ = committed + 1;
  // These answers were lost with the broken connection.
  StreamAck missed{committed, opened.revision().revision(), opened.revision().token(), {}};
  for (const v1::PutNodes& put : opened.put()) {
    if (put.sequence() > state_.last_answered) missed.put.push_back(decode(put));
  }
  const bool is_news = committed > state_.last_answered;
  lock.unlock();
  if (is_news && options_.on_ack) options_.on_ack(missed);
  lock.lock();
  set_revision(opened.revision());
  mark_answered(committed);
  lock.unlock();
  changed_.notify_all();
  return {};
}

void UpdateStreamWorker::write_batches(Call& call) {
  while (const auto messages = next_to_write()) {
    for (const v1::StreamUpdatesRequest& message : *messages) {
      if (!call.Write(message)) return;
      const std::lock_guard lock(mutex_);
      state_.bytes_sent += message.ByteSizeLong();
    }
  }
  call.WritesDone();
}

// Waits for a batch to write. Returns null if the call has ended, or if no batch will follow.
std::shared_ptr<const UpdateStreamWorker::Messages> UpdateStreamWorker::next_to_write() {
  std::unique_lock lock(mutex_);
  const auto all_written = [this] {
    return unanswered_.empty() || next_to_write_ > unanswered_.back().sequence;
  };
  changed_.wait(lock, [&] { return !connected_ || closing_ || !all_written(); });
  if (!connected_ || all_written()) return nullptr;
  next_to_write_ = std::max(next_to_write_, unanswered_.front().sequence);
  return unanswered_[next_to_write_++ - unanswered_.front().sequence].messages;
}

void UpdateStreamWorker::receive(const v1::StreamUpdatesResponse& response) {
  if (response.has_ack()) receive(response.ack());
  if (response.has_reject()) receive(response.reject());
  changed_.notify_all();
}

void UpdateStreamWorker::receive(const v1::UpdateAck& ack) {
  StreamAck accepted{ack.up_to_sequence(), ack.revision().revision(), ack.revision().token(), {}};
  for (const v1::PutNodes& put : ack.put()) {
    accepted.put.push_back(decode(put));
  }
  // The callback comes first, so that a thread that waits for the batch finds it done.
  if (options_.on_ack) options_.on_ack(accepted);
  const std::lock_guard lock(mutex_);
  state_.coalesced = coalesced_in_calls_ + ack.coalesced();
  set_revision(ack.revision());
  mark_answered(ack.up_to_sequence());
}

void UpdateStreamWorker::receive(const v1::UpdateReject& reject) {
  const Error error = rpc_error(reject.code(), reject.message(), reject.reason());
  if (options_.on_reject) options_.on_reject({reject.sequence(), error});
  const std::lock_guard lock(mutex_);
  ++state_.rejected;
  rejects_.insert_or_assign(reject.sequence(), error);
  if (rejects_.size() > kRejectsKept) rejects_.erase(rejects_.begin());
  mark_answered(reject.sequence());  // and all batches before it
}

void UpdateStreamWorker::set_revision(const v1::SceneRevision& revision) {
  state_.revision = revision.revision();
  state_.token = revision.token();
}

void UpdateStreamWorker::mark_answered(std::uint64_t up_to) {
  if (up_to <= state_.last_answered) return;
  state_.last_answered = up_to;
  progressed_ = true;
  while (!unanswered_.empty() && unanswered_.front().sequence <= up_to) unanswered_.pop_front();
}

void UpdateStreamWorker::fail(const Error& error) {
  const std::lock_guard lock(mutex_);
  failed_ = error;
}

}  // namespace sightline::client::calls
