// What gRPC says of a failed call, as an Error.
#pragma once

#include <grpcpp/support/status.h>

#include "client/result.h"

namespace sightline::client {

/// `status` is not OK. The reason is that of the google.rpc.ErrorInfo in its details, if there is
/// one.
Error rpc_error(const grpc::Status& status);

}  // namespace sightline::client
