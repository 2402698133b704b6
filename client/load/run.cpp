// Workers take the requests in order; one lock guards their numbers and the record.
#include "client/load/run.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace sightline::client::load {
namespace {

class Runner {
 public:
  Runner(const RunOptions& options, Target& target, Clock& clock)
      : options_(options), target_(target), clock_(clock), start_(clock.now()) {
    record_.begin = options.warm_up;
    record_.end = options.warm_up;
  }

  Run run(const std::stop_token& stop, const RunProgress& progress) {
    const std::stop_callback cancel(stop, [this] {
      is_stopped_ = true;
      cancel_.request_stop();
    });
    std::vector<std::jthread> workers;
    busy_ = options_.workers;
    for (std::size_t i = 0; i < options_.workers; ++i) workers.emplace_back([this, i] { work(i); });
    supervise(progress);
    workers.clear();
    if (!stop.stop_requested()) count_unsent();
    Run made{.record = std::move(record_), .stable = stable_, .sent = next_};
    if (stop.stop_requested()) made.complete = false;
    if (options_.requests && next_ < *options_.requests) made.complete = false;
    if (cancelled_ > 0) made.complete = false;
    return made;
  }

 private:
  static constexpr Nanoseconds kPause = std::chrono::milliseconds(10);

  Nanoseconds now() { return clock_.now() - start_; }

  struct Ticket {
    std::uint64_t request = 0;
    Nanoseconds due{};
  };

  /// The next request; nothing if the run has ended.
  std::optional<Ticket> take() {
    const std::lock_guard lock(mutex_);
    if (cancel_.stop_requested()) return std::nullopt;
    if (options_.requests && next_ >= *options_.requests) return std::nullopt;
    const Nanoseconds time = now();
    const Nanoseconds due = options_.schedule.due(next_).value_or(time);
    if (options_.until_stable && !stable_ && !ends_at_) {
      stable_ = is_stable(record_, time);
      if (stable_) ends_at_ = time;
    }
    if (due >= end()) return std::nullopt;
    return Ticket{next_++, due};
  }

  Nanoseconds end() const {
    return std::min(options_.warm_up + options_.most, ends_at_.value_or(Nanoseconds::max()));
  }

  /// Counts requests of an open loop that were due, and for which no worker was free until the end.
  void count_unsent() {
    if (!options_.schedule.is_open() || !options_.is_strict) return;
    const std::uint64_t most = options_.requests.value_or(~std::uint64_t{0});
    for (std::uint64_t k = next_; k < most && *options_.schedule.due(k) < end(); ++k)
      ++record_.failed;
  }

  void work(std::size_t worker) {
    while (const auto ticket = take()) {
      if (options_.schedule.is_open())
        clock_.sleep_until(start_ + ticket->due, cancel_.get_token());
      const Nanoseconds sent = now();
      Outcome outcome;
      outcome.state = Outcome::State::kCancelled;
      if (!cancel_.stop_requested())
        outcome = target_.send(worker, ticket->request, cancel_.get_token());
      const bool is_answered = outcome.state == Outcome::State::kAnswered;
      add({ticket->due, sent, now()}, std::move(outcome));
      // A server that answers nothing must not be asked as fast as it refuses.
      if (!is_answered && !options_.schedule.is_open())
        clock_.sleep_until(clock_.now() + kPause, cancel_.get_token());
    }
    const std::lock_guard lock(mutex_);
    --busy_;
    ended_.notify_all();
  }

  void add(const Timing& timing, Outcome outcome) {
    const std::lock_guard lock(mutex_);
    if (outcome.state == Outcome::State::kCancelled) {
      ++cancelled_;
      if (!options_.is_strict || is_stopped_) return;
      outcome.state = Outcome::State::kFailed;
      outcome.error = "not answered before the end of the run";
    }
    add_to(record_, timing, outcome, options_.window);
  }

  /// Waits for the workers, and cancels what is left when the time is over.
  void supervise(const RunProgress& progress) {
    constexpr Nanoseconds kStep = std::chrono::milliseconds(100);
    const Nanoseconds over = options_.warm_up + options_.most + options_.drain;
    std::unique_lock lock(mutex_);
    while (!ended_.wait_for(lock, kStep, [&] { return busy_ == 0; })) {
      const Nanoseconds time = now();
      const std::uint64_t rays = record_.rays;
      lock.unlock();
      if (time > over) cancel_.request_stop();
      if (progress) progress(time, rays);
      lock.lock();
    }
  }

  const RunOptions& options_;
  Target& target_;
  Clock& clock_;
  const Nanoseconds start_;
  std::stop_source cancel_;
  std::atomic<bool> is_stopped_ = false;  // by the caller
  std::mutex mutex_;                      // guards all below
  std::condition_variable ended_;
  Record record_;
  std::uint64_t next_ = 0;
  std::uint64_t cancelled_ = 0;
  std::size_t busy_ = 0;
  bool stable_ = false;
  std::optional<Nanoseconds> ends_at_;
};

}  // namespace

Run run(const RunOptions& options, Target& target, Clock& clock, const std::stop_token& stop,
        const RunProgress& progress) {
  return Runner(options, target, clock).run(stop, progress);
}

}  // namespace sightline::client::load
