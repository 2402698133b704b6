// A journal in memory that commits when a test says so.
#pragma once

#include <deque>
#include <mutex>
#include <optional>
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
  Status follow(std::uint64_t revision, server::scenes::JournalReader& reader) override {
    for (std::uint64_t i = revision; i < kept_.size(); ++i) {
      if (Status taken = reader.batch(i + 1, logged_[i], kept_[i].nodes); !taken) return taken;
    }
    return {};
  }
  Result<std::optional<server::scenes::KeptAnswer>> answer(const std::string& request_id) override {
    for (std::uint64_t i = 0; i < kept_.size(); ++i) {
      if (kept_[i].request_id == request_id)
        return std::optional(server::scenes::KeptAnswer{kept_[i].content, {i + 1, kept_[i].nodes}});
    }
    return std::optional<server::scenes::KeptAnswer>();
  }
  Result<std::optional<server::scenes::KeptProducer>> producer(const std::string& name) override {
    std::optional<server::scenes::KeptProducer> found;
    for (const Entry& entry : kept_) {
      if (entry.producer != name) continue;
      if (!found) found.emplace();
      for (const auto& batch : entry.batches) {
        found->last_committed = batch.sequence;
        found->recent.push_back(batch);
      }
    }
    return found;
  }
  std::string encode(const std::vector<scenegraph::model::Update>& updates,
                     const std::vector<scenegraph::model::NodeId>&) const override {
    encoded_.push_back(updates);
    return std::to_string(encoded_.size() - 1);
  }
  Result<std::vector<scenegraph::model::Update>> decode(const std::string& updates) override {
    return encoded_[std::stoul(updates)];
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
    const bool builds_on_lost = entry.after != nullptr && !entry.after->kept;
    if (builds_on_lost || entry.expected != kept_.size())
      return done(Error{Code::kAborted, "it does not follow", "REVISION_MISMATCH"});
    if (entry.updates) {
      logged_.push_back(encoded_[std::stoul(*entry.updates)]);
      kept_.push_back(entry);
    }
    if (entry.outcome != nullptr) entry.outcome->kept = true;
    done({});
  }
  /// Another server commits updates on top of the last that is kept.
  void commit_of_others(std::vector<scenegraph::model::Update> updates, Entry entry = {}) {
    logged_.push_back(std::move(updates));
    kept_.push_back(std::move(entry));
  }
  void fail() { take().second(Error{Code::kResourceExhausted, "the disk is full", "DISK_FULL"}); }
  std::size_t queued() const {
    const std::lock_guard lock(mutex_);
    return queued_.size();
  }
  /// The entries that are queued, oldest first.
  std::vector<Entry> waiting() const {
    const std::lock_guard lock(mutex_);
    std::vector<Entry> entries;
    for (const auto& [entry, done] : queued_) entries.push_back(entry);
    return entries;
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
