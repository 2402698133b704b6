// A completion queue of its own, which is looked at when the call begins and when it ends: a
// blocking reader would wait for a frozen server without an end.
#include "client/calls/segment_call.h"

#include "client/calls/connection.h"

namespace sightline::client::calls {

SegmentCall::SegmentCall(const std::shared_ptr<grpc::Channel>& channel)
    : stub_(v1::RayQueryService::NewStub(channel)) {}

SegmentCall::~SegmentCall() {
  if (reader_ != nullptr) {
    context_.TryCancel();
    finish();
  }
  queue_.Shutdown();
  void* tag = nullptr;
  bool ok = false;
  while (queue_.Next(&tag, &ok)) {
  }
}

Result<std::unique_ptr<SegmentCall>> SegmentCall::open(
    const std::shared_ptr<grpc::Channel>& channel, std::uint64_t bytes,
    std::chrono::system_clock::time_point deadline, const std::stop_token& stop) {
  std::unique_ptr<SegmentCall> call(new SegmentCall(channel));
  const std::stop_callback cancel(stop, [&] { call->context_.TryCancel(); });
  if (call->start(bytes, deadline)) return call;
  const grpc::Status status = call->finish();
  call->reader_.reset();
  if (call->is_late_)
    return Error{
        Code::kDeadlineExceeded, "the server has not answered the request for a segment", {}};
  if (status.ok())
    return Error{Code::kInternal, "the server has ended the call of a segment without one", {}};
  return rpc_error(status, stop);
}

bool SegmentCall::start(std::uint64_t bytes, std::chrono::system_clock::time_point deadline) {
  v1::OpenSegmentRequest request;
  request.set_bytes(bytes);
  reader_ = stub_->PrepareAsyncOpenSegment(&context_, request, &queue_);
  reader_->StartCall(this);
  if (!completed(deadline)) return false;
  reader_->Read(&opened_, this);
  return completed(deadline);
}

/// Whether the one operation that is under way succeeded. One that comes too late is cancelled.
bool SegmentCall::completed(std::chrono::system_clock::time_point deadline) {
  void* tag = nullptr;
  bool ok = false;
  if (queue_.AsyncNext(&tag, &ok, deadline) == grpc::CompletionQueue::TIMEOUT) {
    is_late_ = true;
    context_.TryCancel();
    queue_.Next(&tag, &ok);
    return false;
  }
  return ok;
}

grpc::Status SegmentCall::finish() {
  grpc::Status status;
  void* tag = nullptr;
  bool ok = false;
  reader_->Finish(&status, this);
  queue_.Next(&tag, &ok);
  return status;
}

}  // namespace sightline::client::calls
