// Reuses the request and reply objects of unary calls, so that large columns need no new memory.
#pragma once

#include <grpcpp/support/message_allocator.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace sightline::server::exec {

/// A pooled reply keeps its old content. The pool must outlive the calls that use it.
template <class Request, class Reply>
class MessagePool final : public grpc::MessageAllocator<Request, Reply> {
 public:
  static constexpr std::size_t kMaxPooled = 8;
  /// Messages larger than this are freed, because a string keeps its largest capacity.
  static constexpr std::size_t kMaxPooledBytes = std::size_t{2} << 20;

  grpc::MessageHolder<Request, Reply>* AllocateMessages() override {
    const std::lock_guard lock(mutex_);
    if (pooled_.empty()) return new Messages(*this);
    Messages* messages = pooled_.back().release();
    pooled_.pop_back();
    return messages;
  }

 private:
  class Messages final : public grpc::MessageHolder<Request, Reply> {
   public:
    explicit Messages(MessagePool& pool) : pool_(pool) {
      this->set_request(&request_.emplace());
      this->set_response(&reply_);
    }
    void Release() override { pool_.take_back(std::unique_ptr<Messages>(this)); }
    void FreeRequest() override { request_.reset(); }
    /// Frees updates of the request: they may be thousands of messages of their own.
    void free_updates() {
      if constexpr (requires { request_->clear_apply(); }) {
        if (request_) request_->clear_apply();
      }
    }
    /// Whether the request is not freed.
    bool is_whole() const { return request_.has_value(); }
    std::size_t bytes() const { return request_->SpaceUsedLong() + reply_.SpaceUsedLong(); }

   private:
    MessagePool& pool_;
    std::optional<Request> request_;
    Reply reply_;
  };

  void take_back(std::unique_ptr<Messages> messages) {
    messages->free_updates();
    if (!messages->is_whole() || messages->bytes() > kMaxPooledBytes) return;
    const std::lock_guard lock(mutex_);
    if (pooled_.size() < kMaxPooled) pooled_.push_back(std::move(messages));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Messages>> pooled_;
};

}  // namespace sightline::server::exec
