// A call of any method, with one message as bytes.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/support/status.h>

#include <memory>
#include <string>

namespace sightline::tests {

/// Calls "/package.Service/Method" with this one message, and waits for the end. `token`: empty for
/// none. `compressed`: by gzip.
grpc::Status call_raw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                      const std::string& message, const std::string& token = {},
                      bool compressed = false);

}  // namespace sightline::tests
