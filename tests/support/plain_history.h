// The state of a scene at each revision: written by threads that update it, read by those that
// cast.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "tests/support/plain_scene.h"

namespace sightline::tests {

/// Revisions are added without gaps, and the last kKept of them are kept. Threads: any.
class PlainHistory {
 public:
  PlainHistory() { add(PlainScene()); }

  std::shared_ptr<const PlainScene> latest() const {
    const std::lock_guard lock(mutex_);
    return revisions_.rbegin()->second;
  }

  /// Waits until the revision has been added. Null: no longer kept.
  std::shared_ptr<const PlainScene> at(std::uint64_t revision) const {
    std::unique_lock lock(mutex_);
    added_.wait(lock, [&] { return revisions_.rbegin()->first >= revision; });
    const auto found = revisions_.find(revision);
    return found == revisions_.end() ? nullptr : found->second;
  }

  void add(PlainScene scene) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t revision = scene.revision();
    revisions_[revision] = std::make_shared<const PlainScene>(std::move(scene));
    if (revisions_.size() > kKept) revisions_.erase(revisions_.begin());
    added_.notify_all();
  }

 private:
  static constexpr std::size_t kKept = 512;

  mutable std::mutex mutex_;
  mutable std::condition_variable added_;
  std::map<std::uint64_t, std::shared_ptr<const PlainScene>> revisions_;
};

/// SIGHTLINE_STRESS_UPDATES: the number of batches of updates of a stress; 10,000 is the full size.
inline std::uint64_t stress_updates(std::uint64_t fallback) {
  const char* text = std::getenv("SIGHTLINE_STRESS_UPDATES");
  const long long value = text != nullptr ? std::strtoll(text, nullptr, 10) : 0;
  return value > 0 ? static_cast<std::uint64_t>(value) : fallback;
}

}  // namespace sightline::tests
