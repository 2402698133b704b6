// A call of any method, with one message as bytes.
#include "tests/server/support/raw_call.h"

#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <condition_variable>
#include <mutex>
#include <optional>

namespace sightline::tests {
namespace {

class SingleMessageCall final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  explicit SingleMessageCall(const std::string& message) : slice_(message), request_(&slice_, 1) {}

  grpc::Status run(const std::shared_ptr<grpc::Channel>& channel, grpc::ClientContext& context,
                   const std::string& method) {
    grpc::GenericStub stub(channel);
    stub.PrepareBidiStreamingCall(&context, method, {}, this);
    StartWriteLast(&request_, {});
    StartRead(&reply_);
    StartCall();
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return end_.has_value(); });
    return *end_;
  }

  void OnReadDone(bool ok) override {
    if (ok) StartRead(&reply_);
  }
  void OnDone(const grpc::Status& status) override {
    const std::lock_guard lock(mutex_);
    end_ = status;
    ended_.notify_all();  // under the lock: this ends as soon as it is free
  }

 private:
  const grpc::Slice slice_;
  grpc::ByteBuffer request_, reply_;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::optional<grpc::Status> end_;
};

}  // namespace

grpc::Status call_raw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                      const std::string& message, const std::string& token, bool compressed) {
  grpc::ClientContext context;
  if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  if (compressed) context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  return SingleMessageCall(message).run(channel, context, method);
}

}  // namespace sightline::tests
