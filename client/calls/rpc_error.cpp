// From gRPC's status to ours.
#include "client/calls/rpc_error.h"

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace sightline::client::calls {
namespace {

Code code_of(grpc::StatusCode code) {
  switch (code) {
    case grpc::CANCELLED:
      return Code::kCancelled;
    case grpc::INVALID_ARGUMENT:
      return Code::kInvalidArgument;
    case grpc::DEADLINE_EXCEEDED:
      return Code::kDeadlineExceeded;
    case grpc::NOT_FOUND:
      return Code::kNotFound;
    case grpc::ALREADY_EXISTS:
      return Code::kAlreadyExists;
    case grpc::PERMISSION_DENIED:
      return Code::kPermissionDenied;
    case grpc::RESOURCE_EXHAUSTED:
      return Code::kResourceExhausted;
    case grpc::FAILED_PRECONDITION:
      return Code::kFailedPrecondition;
    case grpc::ABORTED:
      return Code::kAborted;
    case grpc::OUT_OF_RANGE:
      return Code::kOutOfRange;
    case grpc::UNIMPLEMENTED:
      return Code::kUnimplemented;
    case grpc::INTERNAL:
      return Code::kInternal;
    case grpc::UNAVAILABLE:
      return Code::kUnavailable;
    case grpc::DATA_LOSS:
      return Code::kDataLoss;
    case grpc::UNAUTHENTICATED:
      return Code::kUnauthenticated;
    default:
      return Code::kUnknown;
  }
}

std::string reason_of(const grpc::Status& status) {
  google::rpc::Status details;
  if (!details.ParseFromString(status.error_details())) return {};
  google::rpc::ErrorInfo info;
  for (const auto& detail : details.details()) {
    if (detail.UnpackTo(&info)) return info.reason();
  }
  return {};
}

}  // namespace

Error rpc_error(const grpc::Status& status) {
  return {code_of(status.error_code()), status.error_message(), reason_of(status)};
}

Error rpc_error(int code, const std::string& message, const std::string& reason) {
  return {code_of(static_cast<grpc::StatusCode>(code)), message, reason};
}

}  // namespace sightline::client::calls
