// Publishes writes in order as they are committed.
#include "server/scenes/write_line.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <ranges>
#include <utility>
#include <vector>

#include "server/exec/rpc_status.h"

namespace sightline::server::scenes {

namespace {

/// Whether a write conflicts with what another server has committed first.
bool is_conflict(const Error& error) {
  return error.reason == "REVISION_MISMATCH" || error.reason == "REQUEST_ID_KNOWN" ||
         error.reason == "SEQUENCE_KNOWN" || error.reason == "SCENE_NOT_FOUND";
}

}  // namespace

class WriteLine::Item {
 public:
  explicit Item(Write write) : write_(std::move(write)) {
    write_.entry.outcome = std::make_shared<store::BatchOutcome>();
    if (write_.answer) answers_.push_back(std::move(write_.answer));
  }

  const JournalEntry& entry() const { return write_.entry; }
  bool relaxed() const { return write_.relaxed; }
  Status retry(const Answer& answer) const { return write_.retry(entry(), answer); }
  bool published() const { return published_; }
  bool answered() const { return answered_; }

  void publish() {
    write_.publish();
    published_ = true;
  }
  void join(Answer answer) { answers_.push_back(std::move(answer)); }
  void answer(const Result<Durability>& result) {
    if (std::exchange(answered_, true)) return;
    for (const Answer& answer : std::exchange(answers_, {})) answer(result);
  }
  void when_committed(Committed then) { committed_.push_back(std::move(then)); }
  void end_wait(const Status& status) {
    for (const Committed& then : std::exchange(committed_, {})) then(status);
  }

 private:
  friend class WriteLine;
  Write write_;
  std::vector<Answer> answers_;
  std::vector<Committed> committed_;
  bool appended_ = false, published_ = false, answered_ = false;
  std::optional<Status> outcome_;  // protected by the line's mutex
};

Status WriteLine::ready() {
  advance();
  if (!stalled()) return {};
  for (const auto& item : items_) {
    if (item->appended_ && outcome(*item) != Outcome::kFailed) {
      return Error{Code::kUnavailable,
                   "earlier writes could not be stored and are tried again; retry later",
                   "STORE_FAILING"};
    }
  }
  {
    const std::lock_guard lock(mutex_);
    for (const auto& item : items_) item->outcome_.reset();
  }
  for (const auto& item : items_) item->appended_ = false;
  awaited_ = nullptr;
  append_some();
  return {};
}

WriteLine::Prepared WriteLine::prepare(Write write) {
  return Prepared(1, std::make_shared<Item>(std::move(write)));
}

void WriteLine::add(Prepared prepared) noexcept {
  items_.splice(items_.end(), prepared);
  append_some();
  advance();
}

/// Appends the writes that are not appended, up to one that makes no revision.
void WriteLine::append_some() noexcept {
  if (awaited_ != nullptr && outcome(*awaited_) != Outcome::kCommitted) return;
  awaited_ = nullptr;
  auto next = items_.end();
  while (next != items_.begin() && !(*std::prev(next))->appended_) --next;
  for (; next != items_.end() && awaited_ == nullptr; ++next) {
    append(*next);
    if (!(*next)->entry().updates) awaited_ = *next;
  }
}

void WriteLine::append(const std::shared_ptr<Item>& item) noexcept {
  item->appended_ = true;
  const auto at = std::ranges::find(items_, item);
  item->write_.entry.after = at == items_.begin() ? nullptr : (*std::prev(at))->entry().outcome;
  const Status queued = exec::to_status([&] {
    const auto noted = [this, item, owner = parts_.owner()](const Status& outcome) {
      note(item, outcome);
    };
    return parts_.journal.append(item->entry(), noted);
  });
  if (queued) return;
  const std::lock_guard lock(mutex_);
  item->outcome_ = queued;
}

void WriteLine::note(const std::shared_ptr<Item>& item, const Status& outcome) {
  {
    const std::lock_guard lock(mutex_);
    item->outcome_ = outcome;
  }
  parts_.noted();
}

WriteLine::Outcome WriteLine::outcome(const Item& item) const {
  const std::lock_guard lock(mutex_);
  if (!item.outcome_) return Outcome::kUnknown;
  return item.outcome_->ok() ? Outcome::kCommitted : Outcome::kFailed;
}

void WriteLine::advance() {
  while (!items_.empty()) {
    const std::shared_ptr<Item> item = items_.front();
    const Outcome known = outcome(*item);
    if (known == Outcome::kUnknown) break;
    if (known == Outcome::kFailed) return fail();
    if (!item->published()) item->publish();
    items_.pop_front();
    item->answer(Durability::kCommitted);
    item->end_wait({});
  }
  if (items_.empty() || !items_.front()->published()) stalled_ = false;
  if (!stalled()) publish_relaxed();
  append_some();
}

void WriteLine::publish_relaxed() {
  for (const auto& item : items_) {
    if (item->published()) continue;
    if (!item->relaxed() || outcome(*item) == Outcome::kFailed) break;
    item->publish();
    item->answer(Durability::kRelaxed);
  }
}

/// Drops the writes that are not published: the first could not be committed, and so none after it.
void WriteLine::fail() {
  const Error error = [this] {
    const std::lock_guard lock(mutex_);
    return items_.front()->outcome_->error();
  }();
  Prepared dropped;
  const auto unpublished =
      std::ranges::find_if_not(items_, [](const auto& item) { return item->published(); });
  dropped.splice(dropped.end(), items_, unpublished, items_.end());
  if (items_.empty()) awaited_ = nullptr;
  if (!items_.empty() && !stalled_.exchange(true))
    spdlog::error("event=relaxed_writes_not_stored writes={} error={}", items_.size(),
                  error.message);
  for (const auto& item : items_) item->end_wait(error);
  if (dropped.empty()) return;
  parts_.roll_back();
  if (parts_.catch_up && is_conflict(error)) return retry(dropped);
  for (const auto& item : dropped) {
    item->answer(error);
    item->end_wait({});
  }
}

/// Retries writes. If one fails, those behind it, which may be of the same producer, are not
/// retried either.
void WriteLine::retry(const Prepared& lost) {
  Status good = exec::to_status([this] { return parts_.catch_up(); });
  for (const auto& item : lost) {
    const Answer answer = [item](const Result<Durability>& result) {
      item->answer(result);
      item->end_wait({});
    };
    if (good) good = exec::to_status([&] { return item->retry(answer); });
    if (!good) answer(good.error());
  }
}

const JournalEntry* WriteLine::find(const std::string& request_id) const {
  const auto found = std::ranges::find_if(items_, [&](const auto& item) {
    return !item->answered() && item->entry().request_id == request_id;
  });
  return found == items_.end() ? nullptr : &(*found)->entry();
}

void WriteLine::join(const JournalEntry& entry, Answer answer) {
  const auto found =
      std::ranges::find_if(items_, [&](const auto& item) { return &item->entry() == &entry; });
  (*found)->join(std::move(answer));
}

// These two wait for every write: of those that are retried, a later one may be answered first.

void WriteLine::when_answered(std::function<void()> then) {
  const auto waits = [](const auto& item) { return !item->answered(); };
  const auto left = std::make_shared<std::ptrdiff_t>(std::ranges::count_if(items_, waits));
  if (*left == 0) return then();
  const Answer answer = [left, then = std::move(then)](const Result<Durability>&) {
    if (--*left == 0) then();
  };
  for (const auto& item : items_ | std::views::filter(waits)) item->join(answer);
}

void WriteLine::when_committed(Committed then) {
  if (items_.empty()) return then({});
  struct Waiting {
    std::size_t left;
    Committed then;
    Status status;
  };
  const auto waiting = std::make_shared<Waiting>(Waiting{items_.size(), std::move(then), {}});
  const Committed ended = [waiting](const Status& status) {
    if (waiting->status) waiting->status = status;
    if (--waiting->left == 0) waiting->then(waiting->status);
  };
  for (const auto& item : items_) item->when_committed(ended);
}

}  // namespace sightline::server::scenes
