// Bytes that are no request get INVALID_ARGUMENT and a reason from every method.
#include "server/exec/malformed.h"

#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

#include "tests/server/support/live_server.h"

namespace sightline::tests {
namespace {

/// Sends one message as bytes, or none. The stream stays open on this side.
class RawRequest final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  RawRequest(const std::shared_ptr<grpc::Channel>& channel, const std::string& method)
      : stub_(channel), method_(method) {}

  grpc::Status send(const std::string& message, bool closes) {
    const grpc::Slice slice(message);
    request_ = grpc::ByteBuffer(&slice, 1);
    stub_.PrepareBidiStreamingCall(&context_, method_, {}, this);
    if (closes) {
      StartWriteLast(&request_, {});
    } else {
      StartWrite(&request_);
    }
    StartRead(&reply_);
    StartCall();
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return done_; });
    return status_;
  }

  void OnReadDone(bool ok) override {
    if (ok) StartRead(&reply_);
  }
  void OnDone(const grpc::Status& status) override {
    const std::lock_guard lock(mutex_);
    status_ = status;
    done_ = true;
    changed_.notify_all();
  }

 private:
  grpc::TemplatedGenericStub<grpc::ByteBuffer, grpc::ByteBuffer> stub_;
  std::string method_;
  grpc::ClientContext context_;
  grpc::ByteBuffer request_, reply_;
  std::mutex mutex_;
  std::condition_variable changed_;
  grpc::Status status_;
  bool done_ = false;
};

using Malformed = LiveServer;

const std::string kNoMessage = "\xff\xff\xff\xff";

TEST_F(Malformed, EveryMethodOfOneRequestSaysSo) {
  for (const char* method :
       {"SceneService/CreateScene", "SceneService/GetScene", "SceneService/ListScenes",
        "SceneService/DeleteScene", "SceneService/BatchGetNodes", "SceneService/GetSceneStats",
        "SceneService/CoolScene", "SceneService/ReadMesh", "SceneService/ApplyUpdates",
        "BlobService/FindMissingBlobs", "BlobService/GetUploadStatus", "RayQueryService/CastRays",
        "ServerService/GetServerInfo", "SceneService/ListDeferredCells", "ServerService/ReadLog"}) {
    const grpc::Status status =
        RawRequest(channel_, std::string("/sightline.v1.") + method).send(kNoMessage, true);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << method;
    EXPECT_EQ(reason_of(status), "MALFORMED_MESSAGE") << method;
  }
}

TEST_F(Malformed, EveryStreamOfRequestsSaysSo) {
  for (const char* method : {"SceneService/StreamUpdates", "SceneService/PutScene",
                             "BlobService/UploadBlob", "RayQueryService/StreamCastRays"}) {
    const grpc::Status status =
        RawRequest(channel_, std::string("/sightline.v1.") + method).send(kNoMessage, false);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << method;
    EXPECT_EQ(reason_of(status), "MALFORMED_MESSAGE") << method;
  }
}

TEST_F(Malformed, NamesThatAreNoUtf8AreMalformed) {
  // Field 1, a string of two bytes.
  const std::string message = "\x0a\x02\xc3\x28";
  for (const char* method : {"SceneService/GetScene", "SceneService/DeleteScene"}) {
    const grpc::Status status =
        RawRequest(channel_, std::string("/sightline.v1.") + method).send(message, true);
    EXPECT_EQ(reason_of(status), "MALFORMED_MESSAGE") << method;
  }
}

TEST_F(Malformed, UnknownMethodsStayUnimplemented) {
  const grpc::Status status =
      RawRequest(channel_, "/sightline.v1.SceneService/Nothing").send("", true);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED);
}

// As before: a client may close its side at any time.
TEST(EndOfReads, OnlyParsingTakesTheMarkAway) {
  v1::UploadBlobRequest message;
  server::exec::before_read(message);
  EXPECT_TRUE(server::exec::end_of_reads(message).ok());
  EXPECT_FALSE(message.ParseFromString(kNoMessage));
  EXPECT_FALSE(server::exec::end_of_reads(message).ok());
}

}  // namespace
}  // namespace sightline::tests
