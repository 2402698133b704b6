// The one thread that writes to a database: it commits what waits together.
#include "server/store/writer.h"

#include <algorithm>
#include <exception>
#include <future>
#include <memory>
#include <new>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/store/errors.h"

namespace sightline::server::store {
namespace {

/// The most that one transaction holds.
constexpr std::size_t kGroupSize = 1024;
constexpr std::uint64_t kGroupBytes = std::uint64_t{16} << 20;
/// How long the thread waits, after a transaction for several, for as many to come again.
constexpr std::chrono::milliseconds kGather{2};
/// Transactions for one group before it fails, where the engine says that another may succeed.
constexpr int kAttempts = 3;

}  // namespace

Writer::Writer(std::unique_ptr<Engine> engine, const StoreLimits& limits)
    : engine_(std::move(engine)), limits_(limits) {
  thread_ = std::thread([this] { loop(); });
}

Writer::~Writer() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  queued_.notify_one();
  thread_.join();
}

Status Writer::submit(SceneId scene, Run run, Done done, std::uint64_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    if (figures_.in_flight >= limits_.batches_in_flight) {
      return over_limit("batches_in_flight", figures_.in_flight + 1, limits_.batches_in_flight,
                        "TOO_MANY_COMMITS");
    }
    if (figures_.bytes_in_flight > 0 &&
        figures_.bytes_in_flight + bytes > limits_.bytes_in_flight) {
      return over_limit("bytes_in_flight", figures_.bytes_in_flight + bytes,
                        limits_.bytes_in_flight, "TOO_MANY_COMMITS");
    }
    queue_.push_back({std::move(run), std::move(done), bytes, scene, true, {}, false});
    ++entered_;
    ++figures_.in_flight;
    figures_.bytes_in_flight += bytes;
  }
  queued_.notify_one();
  return {};
}

Status Writer::perform(SceneId scene, const Run& run) {
  // The promise is shared: the writer may still be in set_value() when the caller continues.
  const auto outcome = std::make_shared<std::promise<Status>>();
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back({run,
                      [outcome](const Status& status) { outcome->set_value(status); },
                      0,
                      scene,
                      false,
                      {},
                      false});
    ++entered_;
  }
  queued_.notify_one();
  return outcome->get_future().get();
}

void Writer::flush() {
  std::unique_lock lock(mutex_);
  const std::uint64_t mine = entered_;
  idle_.wait(lock, [&] { return left_ >= mine; });
}

void Writer::expect_garbage() {
  {
    const std::lock_guard lock(mutex_);  // so that a thread that is about to wait sees it
    garbage_ = true;
  }
  queued_.notify_one();
}

Status Writer::last() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

WriterFigures Writer::figures() const {
  const std::lock_guard lock(mutex_);
  return figures_;
}

void Writer::loop() {
  for (;;) {
    Group group = next_group();
    if (group.empty() && !garbage_) return;
    commit(group);
  }
}

/// Waits for work. Empty: there is garbage to purge, or the writer ends.
Writer::Group Writer::next_group() {
  std::unique_lock lock(mutex_);
  queued_.wait(lock, [&] { return !queue_.empty() || ending_ || garbage_; });
  if (ending_) garbage_ = false;  // the next process goes on with it
  if (!queue_.empty()) gather(lock);
  Group group;
  std::uint64_t bytes = 0;
  while (!queue_.empty() && group.size() < kGroupSize &&
         (group.empty() || bytes + queue_.front().bytes <= kGroupBytes)) {
    bytes += queue_.front().bytes;
    group.push_back(std::move(queue_.front()));
    queue_.pop_front();
  }
  last_group_ = group.size();
  return group;
}

/// Waits for clients that come back together after each answer: it takes a moment until all have.
void Writer::gather(std::unique_lock<std::mutex>& lock) {
  if (last_group_ < 2 || ending_) return;
  queued_.wait_for(lock, kGather,
                   [&] { return queue_.size() >= std::min(last_group_, kGroupSize) || ending_; });
}

void Writer::commit(Group& group) {
  const auto begun = std::chrono::steady_clock::now();
  refuse_growth(group);
  const Status outcome = exec::to_status([&] { return transact(group); });
  if (!outcome) garbage_ = garbage_ && !group.empty();
  finish(group, outcome, std::chrono::steady_clock::now() - begun);
  engine_->transaction_ended(tight_);
}

/// Where the disk has no space, work that needs it fails, and the rest is done.
void Writer::refuse_growth(Group& group) {
  std::uint64_t bytes = 0;
  for (const Work& work : group) bytes += work.bytes;
  const Status fits = engine_->admit(bytes);
  tight_ = !fits;
  if (fits) return;
  for (Work& work : group) {
    if (work.bytes == 0) continue;
    work.status = fits;
    work.ended = true;
  }
}

/// Runs all work and commits. If work undoes the transaction, it begins again without that work.
Status Writer::transact(Group& group) {
  int failures = 0;
  for (std::size_t attempt = 0; attempt <= group.size() + kAttempts; ++attempt) {
    isolated_ = attempt > 0 || !engine_->avoids_savepoints();
    bool committed = false;
    Status done = exec::to_status([&] { return transact_once(group, committed); });
    if (committed) return {};
    if (engine_->database().in_transaction()) (void)engine_->database().run("ROLLBACK");
    if (done) continue;
    engine_->failed(done.error());
    if (!engine_->can_repeat(done.error()) || ++failures == kAttempts) return done;
  }
  return Error{Code::kInternal, "the store's transaction was undone again and again", "UNEXPECTED"};
}

/// Success without `committed`: work has undone the transaction.
Status Writer::transact_once(Group& group, bool& committed) {
  std::vector<SceneId> scenes;
  for (const Work& work : group) {
    if (!work.ended && work.scene != 0) scenes.push_back(work.scene);
  }
  std::ranges::sort(scenes);
  scenes.erase(std::ranges::unique(scenes).begin(), scenes.end());
  if (Status begun = engine_->begin(scenes); !begun) return begun;
  if (Status ran = run_all(group); !ran) return ran;
  if (!engine_->database().in_transaction()) return {};
  purge();
  Status done = engine_->commit();
  committed = done.ok();
  return done;
}

/// Runs all work. Fails if the engine has failed; then nothing of the group can be done.
Status Writer::run_all(Group& group) {
  for (Work& work : group) {
    if (work.ended) continue;
    work.status = exec::to_status([&] { return run_one(work); });
    if (work.status) continue;
    if (is_of_engine(work.status.error())) return work.status;
    if (!isolated_) return engine_->database().run("ROLLBACK");
    if (!engine_->database().in_transaction()) {
      work.ended = true;
      return {};
    }
  }
  return {};
}

Status Writer::run_one(Work& work) {
  return isolated_ ? run_isolated(work) : work.run(engine_->database());
}

/// Runs one piece of work. What it wrote is undone if it fails.
Status Writer::run_isolated(Work& work) {
  if (Status begun = engine_->database().execute("SAVEPOINT one"); !begun) return begun;
  Status done = exec::to_status([&] { return work.run(engine_->database()); });
  if (!engine_->database().in_transaction()) return done;
  if (!done) {
    if (Status undone = engine_->database().execute("ROLLBACK TO one"); !undone) return undone;
  }
  if (Status released = engine_->database().execute("RELEASE one"); !released) return released;
  return done;
}

/// Purges a step within the transaction. Garbage that cannot be purged stays until the next start.
void Writer::purge() {
  if (!garbage_) return;
  Work step;
  bool more = false;
  step.run = [&](Database& /*database*/) -> Status {
    const auto purged = engine_->purge(tight_);
    if (!purged) return purged.error();
    more = *purged;
    return {};
  };
  const Status done = exec::to_status([&] { return run_isolated(step); });
  if (!done || !more) garbage_ = false;
}

/// Tells the callers how their work ended, in order.
void Writer::finish(Group& group, const Status& outcome, std::chrono::nanoseconds took) {
  std::uint64_t limited = 0;
  std::uint64_t bytes = 0;
  for (const Work& work : group) {
    if (!work.limited) continue;
    ++limited;
    bytes += work.bytes;
  }
  {
    const std::lock_guard lock(mutex_);
    last_ = outcome;
    figures_.in_flight -= limited;
    figures_.bytes_in_flight -= bytes;
    figures_.failures += outcome ? 0 : 1;
    if (outcome && !group.empty()) {
      figures_.commits += 1;
      figures_.batches += limited;
      figures_.commit_time += took;
    }
  }
  for (const Work& work : group) work.done(work.ended || outcome ? work.status : outcome);
  {
    const std::lock_guard lock(mutex_);
    left_ += group.size();
  }
  idle_.notify_all();
}

}  // namespace sightline::server::store
