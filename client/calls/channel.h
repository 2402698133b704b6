// The connection to a server: its address, the retries, the deadlines.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace sightline::client::calls {

/// Calls that only read are tried again, by gRPC, when the server is unavailable; see
/// kServiceConfig.
std::shared_ptr<grpc::Channel> open_channel(const std::string& endpoint);

void set_timeout(grpc::ClientContext& context, std::optional<std::chrono::milliseconds> timeout);

}  // namespace sightline::client::calls
