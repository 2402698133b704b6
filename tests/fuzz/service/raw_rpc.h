// A call with any bytes as its messages.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace sightline::tests {

struct RawReply {
  grpc::Status status;
  std::vector<std::string> messages;
};

/// Sends the messages one after the other, reads every reply, and waits for the end of the call.
/// `method`: as "/sightline.v1.ServerService/GetServerInfo".
RawReply raw_rpc(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                 const std::vector<std::string>& messages, std::chrono::milliseconds deadline);

}  // namespace sightline::tests
