// Code that runs in a callback of gRPC, and channels that such code may release. Internal to the
// library.
#pragma once

#include <grpcpp/channel.h>

#include <memory>

namespace sightline::client::calls {

/// Marks the thread as one that runs a callback of gRPC. Whatever the callback releases must be
/// released while this lives.
class CallbackScope {
 public:
  CallbackScope() : outer_(here) { here = true; }
  CallbackScope(const CallbackScope&) = delete;
  CallbackScope& operator=(const CallbackScope&) = delete;
  ~CallbackScope() { here = outer_; }

  static bool is_here() { return here; }

 private:
  inline static thread_local bool here = false;
  bool outer_;
};

/// A channel whose last owner may release it in a callback, too. gRPC's threads for callbacks end
/// with the last channel that has used them, which waits for them: one of them would wait for
/// itself. So a callback leaves the release to another thread.
std::shared_ptr<grpc::Channel> released_outside_callbacks(std::shared_ptr<grpc::Channel> channel);

}  // namespace sightline::client::calls
