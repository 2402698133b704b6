// The writes of a scene that are applied at its head but not yet kept, in order.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "proto/result.h"
#include "server/scenes/journal.h"

namespace sightline::server::scenes {

/// A write is published, and then answered, once all before it are published and it is committed. A
/// relaxed write need not be committed for that. When one cannot be committed, all that are not
/// published are dropped and answered with the error. Published writes stay and are appended again;
/// until they are committed, relaxed writes wait for their commit, too. Used on the scene's write
/// queue, except for note().
///
/// If another server commits first, a write is retried on top of what that server has committed.
///
/// The journal refuses a write if the write before it was not kept (JournalEntry::after). Behind a
/// write that makes no revision, the next one is appended only once that is committed.
class WriteLine {
 public:
  using Answer = std::function<void(const Result<Durability>&)>;
  using Committed = std::function<void(const Status&)>;

  struct Write {
    JournalEntry entry;
    bool relaxed = false;
    std::function<void()> publish;  ///< Shows it to readers. Does not throw.
    Answer answer;                  ///< May be empty. Does not throw.
    /// Retries the write, when others have committed first: adds it anew with this answer, or
    /// answers it. On an error it has done neither. Empty: it is answered with the error.
    std::function<Status(const JournalEntry& lost, const Answer& answer)> retry = {};
  };
  class Item;
  /// At most one item: an entry of the line's list, made in advance.
  using Prepared = std::list<std::shared_ptr<Item>>;

  struct Parts {
    Journal& journal;                 ///< Outlives the line.
    std::function<void()> roll_back;  ///< Drops what is applied and not published.
    std::function<void()> noted;      ///< Called on any thread: advance() should be called.
    std::function<std::shared_ptr<const void>()> owner;  ///< What keeps the line alive.
    /// Publishes what others have committed, before writes are retried. Empty: there are none.
    std::function<Status()> catch_up = {};
  };
  explicit WriteLine(Parts parts) : parts_(std::move(parts)) {}

  /// Appends what could not be committed again. Errors: kUnavailable, with the reason, while the
  /// journal still works on it.
  Status ready();
  /// Makes an item for add(). Throws std::bad_alloc.
  static Prepared prepare(Write write);
  /// Adds the write to the line. Its answer may be given before this returns.
  void add(Prepared prepared) noexcept;

  /// Publishes and answers what can be.
  void advance();

  /// Writes that are not committed.
  std::size_t size() const { return items_.size(); }
  /// Whether published writes could not be committed. Threads: any.
  bool stalled() const { return stalled_.load(std::memory_order_relaxed); }

  /// The write of a request that is not answered yet, or null.
  const JournalEntry* find(const std::string& request_id) const;
  /// Calls answer() when that write is answered.
  void join(const JournalEntry& entry, Answer answer);
  /// Calls then() when all writes that were added before are answered.
  void when_answered(std::function<void()> then);
  /// Calls then() when all writes that were added before are committed or dropped. An error: one
  /// that is published is not committed.
  void when_committed(Committed then);

 private:
  void publish_relaxed();
  void append_some() noexcept;
  void append(const std::shared_ptr<Item>& item) noexcept;
  void note(const std::shared_ptr<Item>& item, const Status& outcome);
  enum class Outcome : std::uint8_t { kUnknown, kCommitted, kFailed };
  Outcome outcome(const Item& item) const;
  void fail();
  void retry(const Prepared& lost);

  const Parts parts_;
  Prepared items_;                 // published ones first, those that are not appended last
  std::shared_ptr<Item> awaited_;  // the last one that makes no revision, until it is committed
  std::atomic<bool> stalled_{false};
  mutable std::mutex mutex_;  // protects the outcomes of items
};

}  // namespace sightline::server::scenes
