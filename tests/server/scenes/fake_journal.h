// A journal in memory that commits when a test says so.
#pragma once

#include <deque>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/scenes/journal.h"

namespace sightline::tests {

class FakeJournal final : public server::scenes::Journal {
 public:
  using Entry = server::scenes::JournalEntry;

  Status load(server::scenes::JournalReader& reader) override {
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (Status taken = reader.batch(i + 1, logged_[i], kept_[i].nodes); !taken) return taken;
    }
    return {};
  }
  std::string encode(const std::vector<scenegraph::model::Update>& updates,
                     const std::vector<scenegraph::model::NodeId>&) const override {
    encoded_.push_back(updates);
    return std::to_string(encoded_.size() - 1);
  }
  Status append(const Entry& entry, Done done) override {
    if (refuses) return Error{Code::kResourceExhausted, "the queue is full", "QUEUE_FULL"};
    const std::lock_guard lock(mutex_);
    queued_.emplace_back(entry, std::move(done));
    return {};
  }
  void published(const scenegraph::SceneState&, std::uint64_t) noexcept override {}
  Status remove() override { return {}; }

  /// Commits the oldest entry, if it follows the last that is kept.
  void commit() {
    auto [entry, done] = take();
    if (entry.expected != kept_.size())
      return done(Error{Code::kAborted, "it does not follow", "REVISION_MISMATCH"});
    if (entry.updates) {
      logged_.push_back(encoded_[std::stoul(*entry.updates)]);
      kept_.push_back(entry);
    }
    done({});
  }
  void fail() { take().second(Error{Code::kResourceExhausted, "the disk is full", "DISK_FULL"}); }
  std::size_t queued() const {
    const std::lock_guard lock(mutex_);
    return queued_.size();
  }
  const std::vector<Entry>& kept() const { return kept_; }

  bool refuses = false;

 private:
  std::pair<Entry, Done> take() {
    const std::lock_guard lock(mutex_);
    auto oldest = std::move(queued_.front());
    queued_.pop_front();
    return oldest;
  }

  mutable std::vector<std::vector<scenegraph::model::Update>> encoded_;
  std::vector<std::vector<scenegraph::model::Update>> logged_;
  std::vector<Entry> kept_;
  mutable std::mutex mutex_;
  std::deque<std::pair<Entry, Done>> queued_;
};

}  // namespace sightline::tests
