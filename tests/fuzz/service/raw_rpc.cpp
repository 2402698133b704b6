// A call with any bytes as its messages.
#include "tests/fuzz/service/raw_rpc.h"

#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <cstddef>
#include <semaphore>

namespace sightline::tests {
namespace {

class RawRpc final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  RawRpc(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
         const std::vector<std::string>& messages, std::chrono::milliseconds deadline)
      : stub_(channel), messages_(messages) {
    context_.set_deadline(std::chrono::system_clock::now() + deadline);
    stub_.PrepareBidiStreamingCall(&context_, method, {}, this);
    send_next();
    StartRead(&reply_);
    StartCall();
  }

  RawReply end() {
    done_.acquire();
    return std::move(result_);
  }

  void OnWriteDone(bool ok) override {
    if (ok) send_next();
  }
  void OnReadDone(bool ok) override {
    if (!ok) return;
    std::vector<grpc::Slice> slices;
    static_cast<void>(reply_.Dump(&slices));
    std::string text;
    for (const grpc::Slice& slice : slices)
      text.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    result_.messages.push_back(std::move(text));
    StartRead(&reply_);
  }
  void OnDone(const grpc::Status& status) override {
    result_.status = status;
    done_.release();
  }

 private:
  void send_next() {
    if (sent_ == messages_.size()) return StartWritesDone();
    const grpc::Slice slice(messages_[sent_++]);
    request_ = grpc::ByteBuffer(&slice, 1);
    StartWrite(&request_);
  }

  grpc::TemplatedGenericStub<grpc::ByteBuffer, grpc::ByteBuffer> stub_;
  grpc::ClientContext context_;
  const std::vector<std::string>& messages_;
  std::size_t sent_ = 0;
  grpc::ByteBuffer request_, reply_;
  RawReply result_;
  std::binary_semaphore done_{0};
};

}  // namespace

RawReply raw_rpc(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                 const std::vector<std::string>& messages, std::chrono::milliseconds deadline) {
  RawRpc call(channel, method, messages, deadline);
  return call.end();
}

}  // namespace sightline::tests
