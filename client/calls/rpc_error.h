// What gRPC says of a failed call, as an Error.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "client/result.h"

namespace sightline::client::calls {

/// `status` is not OK. The reason is that of the google.rpc.ErrorInfo in its details, if there is
/// one.
Error rpc_error(const grpc::Status& status);

/// Of the parts of an error within a message; `code` is of google.rpc.Code.
Error rpc_error(int code, const std::string& message, const std::string& reason);

}  // namespace sightline::client::calls
