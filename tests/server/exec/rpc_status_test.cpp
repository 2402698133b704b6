// Errors as gRPC statuses with machine-readable details, and text of callers in messages and logs.
#include "server/exec/rpc_status.h"

#include <gtest/gtest.h>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/exec/admission.h"

namespace sightline::server::exec {
namespace {

google::rpc::ErrorInfo info_of(const grpc::Status& status) {
  google::rpc::Status details;
  EXPECT_TRUE(details.ParseFromString(status.error_details()));
  EXPECT_EQ(details.code(), status.error_code());
  EXPECT_EQ(details.message(), status.error_message());
  EXPECT_EQ(details.details_size(), 1);
  EXPECT_EQ(details.details(0).type_url(), "type.googleapis.com/google.rpc.ErrorInfo");
  google::rpc::ErrorInfo info;
  EXPECT_TRUE(details.details(0).UnpackTo(&info));
  return info;
}

TEST(RpcStatus, HasCodeMessageAndReason) {
  const grpc::Status status =
      to_grpc(Error{Code::kNotFound, "there is no scene x", "SCENE_NOT_FOUND"});
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(status.error_message(), "there is no scene x");
  EXPECT_EQ(info_of(status).reason(), "SCENE_NOT_FOUND");
  EXPECT_EQ(info_of(status).domain(), "sightline");
}

TEST(RpcStatus, MapsEveryCodeToTheGrpcCodeOfTheSameName) {
  const std::pair<Code, grpc::StatusCode> pairs[] = {
      {Code::kInvalidArgument, grpc::StatusCode::INVALID_ARGUMENT},
      {Code::kNotFound, grpc::StatusCode::NOT_FOUND},
      {Code::kAlreadyExists, grpc::StatusCode::ALREADY_EXISTS},
      {Code::kFailedPrecondition, grpc::StatusCode::FAILED_PRECONDITION},
      {Code::kAborted, grpc::StatusCode::ABORTED},
      {Code::kOutOfRange, grpc::StatusCode::OUT_OF_RANGE},
      {Code::kResourceExhausted, grpc::StatusCode::RESOURCE_EXHAUSTED},
      {Code::kCancelled, grpc::StatusCode::CANCELLED},
      {Code::kDeadlineExceeded, grpc::StatusCode::DEADLINE_EXCEEDED},
      {Code::kUnavailable, grpc::StatusCode::UNAVAILABLE},
      {Code::kDataLoss, grpc::StatusCode::DATA_LOSS},
      {Code::kUnauthenticated, grpc::StatusCode::UNAUTHENTICATED},
      {Code::kPermissionDenied, grpc::StatusCode::PERMISSION_DENIED},
      {Code::kUnimplemented, grpc::StatusCode::UNIMPLEMENTED},
      {Code::kInternal, grpc::StatusCode::INTERNAL}};
  for (const auto& [code, expected] : pairs)
    EXPECT_EQ(to_grpc(Error{code, "m", ""}).error_code(), expected);
}

TEST(RpcStatus, WithoutAReasonTheCodeIsTheReason) {
  EXPECT_EQ(info_of(to_grpc(Error{Code::kDataLoss, "m", ""})).reason(), "DATA_LOSS");
}

TEST(RpcStatus, SaysWhenToRetryAFullQueue) {
  const auto details = [](const char* reason) {
    const grpc::Status status = to_grpc(Error{Code::kResourceExhausted, "full", reason});
    google::rpc::Status decoded;
    EXPECT_TRUE(decoded.ParseFromString(status.error_details()));
    return decoded.details();
  };
  ASSERT_EQ(details(kQueueFull).size(), 2);
  google::rpc::RetryInfo retry;
  ASSERT_TRUE(details(kQueueFull)[1].UnpackTo(&retry));
  EXPECT_EQ(retry.retry_delay().seconds() * 1000 + retry.retry_delay().nanos() / 1'000'000,
            std::chrono::milliseconds(kRetryDelay).count());
  EXPECT_EQ(details("TOO_MANY_NODES").size(), 1) << "a retry would not help";
  EXPECT_TRUE(asks_to_retry(to_grpc(Error{Code::kResourceExhausted, "full", kQueueFull})));
  EXPECT_FALSE(asks_to_retry(to_grpc(Error{Code::kResourceExhausted, "full", "TOO_MANY_NODES"})));
  EXPECT_FALSE(asks_to_retry(grpc::Status::OK));
}

TEST(RpcStatus, CutsLongMessagesBetweenCharacters) {
  std::string message = "x";
  while (message.size() < 5000) message += "\xc3\xa4";
  const grpc::Status status = to_grpc(Error{Code::kInternal, message, ""});
  EXPECT_LE(status.error_message().size(), kMaxStatusMessage + 3);
  info_of(status);
  EXPECT_EQ(status.error_message().substr(status.error_message().size() - 5), "\xc3\xa4...");
}

TEST(RpcStatus, MessagesAreOneLine) {
  const grpc::Status status = to_grpc(Error{Code::kInternal, "a\r\nb\x1b[2J\xc3\xa4\x7f", ""});
  EXPECT_EQ(status.error_message(), "a??b?[2J\xc3\xa4?");
}

TEST(RpcStatus, OkIsOk) { EXPECT_TRUE(to_grpc(Status()).ok()); }

TEST(Quote, ShowsPrintableText) { EXPECT_EQ(quote("a b"), "\"a b\""); }

TEST(Quote, CannotForgeALogLine) {
  EXPECT_EQ(quote("a\nevent=x"), "\"a?event=x\"");
  EXPECT_EQ(quote("say \"hi\" \\"), R"("say \"hi\" \\")");
  EXPECT_EQ(quote(std::string_view("\0\x7f\xff", 3)), "\"???\"");
}

TEST(Quote, CutsLongText) {
  EXPECT_EQ(quote(std::string(1000, 'x')),
            "\"" + std::string(kMaxQuoted, 'x') + "\"... (1000 bytes)");
}

}  // namespace
}  // namespace sightline::server::exec
