// A deleter that asks where it runs.
#include "client/calls/callback_scope.h"

#include <exception>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

namespace sightline::client::calls {
namespace {

using Channel = std::shared_ptr<grpc::Channel>;

void release_on_a_thread(Channel channel) noexcept {
  // Without memory the process ends; without a thread the channel stays until it does.
  auto* const kept = new (std::nothrow) Channel(std::move(channel));
  if (kept == nullptr) std::terminate();
  try {
    std::thread([kept] { delete kept; }).detach();
  } catch (const std::system_error&) {
  }
}

}  // namespace

Channel released_outside_callbacks(Channel channel) {
  grpc::Channel* const plain = channel.get();
  return {plain, [owned = std::move(channel)](grpc::Channel*) mutable {
            if (CallbackScope::is_here()) {
              release_on_a_thread(std::move(owned));
            } else {
              owned.reset();
            }
          }};
}

}  // namespace sightline::client::calls
