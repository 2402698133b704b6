// Unary and streamed updates.
#include "tests/e2e/update_sender.h"

#include <grpcpp/client_context.h>

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace sightline::tests {
namespace {

using Clock = std::chrono::steady_clock;

Error failed(const std::string& message) {
  return {Code::kInternal, "the server: " + message, "SERVER"};
}

class UnarySender final : public UpdateSender {
 public:
  UnarySender(const std::shared_ptr<grpc::Channel>& channel, const std::string& scene)
      : stub_(v1::SceneService::NewStub(channel)) {
    request_.set_scene(scene);
  }

  Status send(Updates updates) override {
    grpc::ClientContext context;
    v1::ApplyUpdatesResponse reply;
    *request_.mutable_updates() = std::move(updates);
    const grpc::Status status = stub_->ApplyUpdates(&context, request_, &reply);
    if (!status.ok()) return failed(status.error_message());
    acked_.push_back(Clock::now());
    return {};
  }
  Status finish() override { return {}; }
  std::vector<Time> acked() const override { return acked_; }

 private:
  std::unique_ptr<v1::SceneService::Stub> stub_;
  v1::ApplyUpdatesRequest request_;
  std::vector<Time> acked_;
};

class StreamSender final : public UpdateSender {
 public:
  StreamSender(const std::shared_ptr<grpc::Channel>& channel, const std::string& scene)
      : stub_(v1::SceneService::NewStub(channel)), call_(stub_->StreamUpdates(&context_)) {
    v1::StreamUpdatesRequest open;
    open.mutable_open()->set_scene(scene);
    open.mutable_open()->set_producer("updates");
    call_->Write(open);
    reader_ = std::jthread([this] { read(); });
  }
  ~StreamSender() override {
    if (reader_.joinable()) context_.TryCancel();
  }

  Status send(Updates updates) override {
    {
      std::unique_lock lock(mutex_);
      acked_changed_.wait(lock, [&] { return over_ || sent_ < acked_.size() + window_; });
      if (over_) return failed(complaint_);
    }
    v1::StreamUpdatesRequest request;
    request.mutable_batch()->set_sequence(++sent_);
    *request.mutable_batch()->mutable_updates() = std::move(updates);
    return call_->Write(request) ? Status() : failed("the call has ended");
  }

  Status finish() override {
    call_->WritesDone();
    if (reader_.joinable()) reader_.join();
    const grpc::Status status = call_->Finish();
    if (!status.ok()) return failed(status.error_message());
    if (acked_.size() == sent_ && complaint_.empty()) return {};
    return failed(complaint_.empty() ? "not all batches were acknowledged" : complaint_);
  }
  std::vector<Time> acked() const override { return acked_; }

 private:
  void read() {
    v1::StreamUpdatesResponse reply;
    while (call_->Read(&reply)) {
      const std::lock_guard lock(mutex_);
      if (reply.has_opened()) window_ = reply.opened().window();
      if (reply.has_reject()) complaint_ = reply.reject().message();
      if (reply.has_ack()) acked_.resize(reply.ack().up_to_sequence(), Clock::now());
      acked_changed_.notify_all();
    }
    const std::lock_guard lock(mutex_);
    over_ = true;
    acked_changed_.notify_all();
  }

  std::unique_ptr<v1::SceneService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>>
      call_;
  std::mutex mutex_;
  std::condition_variable acked_changed_;
  std::uint64_t sent_ = 0;
  std::uint64_t window_ = 0;  // Until the call is opened
  bool over_ = false;
  std::string complaint_;
  std::vector<Time> acked_;
  std::jthread reader_;
};

}  // namespace

std::unique_ptr<UpdateSender> UpdateSender::unary(const std::shared_ptr<grpc::Channel>& channel,
                                                  const std::string& scene) {
  return std::make_unique<UnarySender>(channel, scene);
}

std::unique_ptr<UpdateSender> UpdateSender::stream(const std::shared_ptr<grpc::Channel>& channel,
                                                   const std::string& scene) {
  return std::make_unique<StreamSender>(channel, scene);
}

}  // namespace sightline::tests
