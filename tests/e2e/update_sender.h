// Sends revisions one after the other, and records when each was acknowledged.
#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "proto/result.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::tests {

/// Threads: one caller.
class UpdateSender {
 public:
  using Updates = google::protobuf::RepeatedPtrField<v1::Update>;
  using Time = std::chrono::steady_clock::time_point;

  /// One call of ApplyUpdates for each; the next starts when the one before has returned.
  static std::unique_ptr<UpdateSender> unary(const std::shared_ptr<grpc::Channel>& channel,
                                             const std::string& scene);
  /// One call of StreamUpdates for all, as far ahead of the acks as its window allows.
  static std::unique_ptr<UpdateSender> stream(const std::shared_ptr<grpc::Channel>& channel,
                                              const std::string& scene);
  virtual ~UpdateSender() = default;

  /// Errors: the server's.
  virtual Status send(Updates updates) = 0;
  /// Waits for missing acknowledgements. Errors: as of send().
  virtual Status finish() = 0;
  /// After finish(): the time of each acknowledgement, in the order of sending.
  virtual std::vector<Time> acked() const = 0;
};

}  // namespace sightline::tests
