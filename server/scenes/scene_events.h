// Listeners of one scene.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>

namespace sightline::server::scenes {

/// notify() is called after a new revision, after another call takes over a producer, and after the
/// removal of the scene. The listener checks the scene to find out which. Threads: any, for every
/// member.
class SceneEvents {
 public:
  using Listener = std::function<void()>;

  /// `listener` must be short and must call neither subscribe() nor unsubscribe(). What it throws
  /// is logged.
  std::uint64_t subscribe(Listener listener);
  /// When this returns, the listener is not running and will not be called.
  void unsubscribe(std::uint64_t id);
  void notify() noexcept;

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, Listener> listeners_;
  std::uint64_t next_ = 1;
};

}  // namespace sightline::server::scenes
