// Sends one revision after the other, and notes when each was acknowledged.
#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "accel/result.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::tests {

/// One user.
class UpdateSender {
 public:
  using Updates = google::protobuf::RepeatedPtrField<v1::Update>;
  using Time = std::chrono::steady_clock::time_point;

  /// A call of ApplyUpdates for each, the next when the one before has returned.
  static std::unique_ptr<UpdateSender> unary(const std::shared_ptr<grpc::Channel>& channel,
                                             const std::string& scene);
  /// All through one call of StreamUpdates, as far ahead of the acks as its window lets.
  static std::unique_ptr<UpdateSender> stream(const std::shared_ptr<grpc::Channel>& channel,
                                              const std::string& scene);
  virtual ~UpdateSender() = default;

  /// Errors: what the server answers.
  virtual Status send(Updates updates) = 0;
  /// Waits for what is not acknowledged yet. Errors: as of send().
  virtual Status finish() = 0;
  /// After finish(): when each was acknowledged, in the order in which they were sent.
  virtual std::vector<Time> acked() const = 0;
};

}  // namespace sightline::tests
