// The call that keeps a segment. Internal to the library.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/support/async_stream.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>

#include "client/result.h"
#include "sightline/v1/query.grpc.pb.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

/// An OpenSegment call, which stays open until this is destroyed: the server then takes the segment
/// back. No thread waits for it.
class SegmentCall {
 public:
  /// Returns when the server has answered. Errors: the server's; kDeadlineExceeded; kCancelled.
  static Result<std::unique_ptr<SegmentCall>> open(const std::shared_ptr<grpc::Channel>& channel,
                                                   std::uint64_t bytes,
                                                   std::chrono::system_clock::time_point deadline,
                                                   const std::stop_token& stop);
  ~SegmentCall();
  SegmentCall(const SegmentCall&) = delete;
  SegmentCall& operator=(const SegmentCall&) = delete;

  const v1::OpenSegmentResponse& opened() const { return opened_; }

 private:
  explicit SegmentCall(const std::shared_ptr<grpc::Channel>& channel);

  bool start(std::uint64_t bytes, std::chrono::system_clock::time_point deadline);
  bool completed(std::chrono::system_clock::time_point deadline);
  grpc::Status finish();

  const std::unique_ptr<v1::RayQueryService::Stub> stub_;  // keeps the channel
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::ClientAsyncReader<v1::OpenSegmentResponse>> reader_;
  v1::OpenSegmentResponse opened_;
  bool is_late_ = false;
};

}  // namespace sightline::client::calls
