// A node that the updates of a load test move, so that the scene's own nodes stay as they are.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "client/client.h"

namespace sightline::client::load {

/// A copy of one of the scene's instances, beside it, which is deleted with the object. It is seen
/// by all who query the scene meanwhile.
class MovingCopy {
 public:
  static constexpr const char* kName = "sightline-load";

  /// Copies the first instance in the order of ids. A copy that an earlier run left is deleted.
  /// `client` must outlive the object. Errors: kFailedPrecondition, the scene has no instance;
  /// those of the calls.
  static Result<MovingCopy> add(const Client& client, const std::string& scene);
  MovingCopy(MovingCopy&& other) noexcept;
  MovingCopy(const MovingCopy&) = delete;
  ~MovingCopy();

  /// Moves the node to its next position on a small circle: one update, one revision. Threads: any.
  Status move(const Client& client);

 private:
  MovingCopy(const Client& client, std::string scene, std::uint64_t node, const Transform& middle,
             double radius)
      : client_(&client), scene_(std::move(scene)), node_(node), middle_(middle), radius_(radius) {}

  const Client* client_;
  std::string scene_;
  std::uint64_t node_;  // 0: moved from
  Transform middle_;
  double radius_;
  std::atomic<std::uint64_t> steps_ = 0;
};

}  // namespace sightline::client::load
