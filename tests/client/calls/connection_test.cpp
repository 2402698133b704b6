// Errors from gRPC, and request ids.
#include <gtest/gtest.h>

#include <set>
#include <stop_token>

#include "client/calls/connection.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace sightline::client::calls {
namespace {

TEST(RpcError, EveryGrpcCodeHasItsOwnCode) {
  std::set<Code> codes;
  for (int code = grpc::CANCELLED; code <= grpc::UNAUTHENTICATED; ++code) {
    codes.insert(rpc_error(grpc::Status(static_cast<grpc::StatusCode>(code), "")).code);
  }
  EXPECT_EQ(codes.size(), 16U);
  EXPECT_EQ(rpc_error(grpc::Status(grpc::NOT_FOUND, "gone")).code, Code::kNotFound);
  EXPECT_EQ(rpc_error(grpc::Status(grpc::NOT_FOUND, "gone")).message, "gone");
}

TEST(RpcError, TheReasonIsReadFromErrorInfo) {
  google::rpc::ErrorInfo info;
  info.set_reason("NODE_CYCLE");
  google::rpc::Status details;
  details.add_details();
  details.add_details()->PackFrom(info);
  const grpc::Status status(grpc::INVALID_ARGUMENT, "cycle", details.SerializeAsString());
  EXPECT_EQ(rpc_error(status).reason, "NODE_CYCLE");
}

TEST(RpcError, ACallThatNothingCancelledWasEndedByTheServer) {
  const grpc::Status cancelled(grpc::CANCELLED, "CANCELLED");
  std::stop_source stop;
  EXPECT_EQ(rpc_error(cancelled, stop.get_token()).code, Code::kUnavailable);
  EXPECT_EQ(rpc_error(cancelled, {}).code, Code::kUnavailable);
  stop.request_stop();
  EXPECT_EQ(rpc_error(cancelled, stop.get_token()).code, Code::kCancelled);
  EXPECT_EQ(rpc_error(grpc::Status(grpc::NOT_FOUND, ""), {}).code, Code::kNotFound);
}

TEST(RpcError, InvalidDetailsGiveNoReason) {
  EXPECT_EQ(rpc_error(grpc::Status(grpc::INTERNAL, "", "\xff\xff")).reason, "");
  EXPECT_EQ(rpc_error(grpc::Status(grpc::INTERNAL, "")).reason, "");
}

TEST(RequestId, IsAUniqueVersionFourUuid) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string id = random_request_id();
    EXPECT_EQ(id.size(), 32U);
    EXPECT_EQ(id.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_EQ(id[12], '4');
    EXPECT_NE(std::string("89ab").find(id[16]), std::string::npos);
    EXPECT_TRUE(seen.insert(id).second);
  }
}

}  // namespace

}  // namespace sightline::client::calls
