// Request and reply of a unary call on an arena: for requests of many small messages.
#pragma once

#include <google/protobuf/arena.h>
#include <google/protobuf/message.h>
#include <grpcpp/support/message_allocator.h>

#include <cstddef>
#include <memory>
#include <optional>

namespace sightline::server::exec {

/// gRPC parses on the threads that answer small casts. Thousands of messages of their own would be
/// allocated, counted and freed there, which takes longer than to parse them.
template <class Request, class Reply>
class ArenaMessages final : public grpc::MessageAllocator<Request, Reply> {
 public:
  grpc::MessageHolder<Request, Reply>* AllocateMessages() override {
    return std::make_unique<Messages>().release();
  }

 private:
  class Messages final : public grpc::MessageHolder<Request, Reply> {
   public:
    Messages() {
      google::protobuf::ArenaOptions options;
      options.start_block_size = kFirstBlock;
      options.max_block_size = kLargestBlock;
      arena_.emplace(options);
      this->set_request(google::protobuf::Arena::CreateMessage<Request>(&*arena_));
      this->set_response(&reply_);
    }
    void Release() override { delete this; }
    void FreeRequest() override { arena_.reset(); }

   private:
    static constexpr std::size_t kFirstBlock = std::size_t{1} << 10;
    static constexpr std::size_t kLargestBlock = std::size_t{64} << 10;

    std::optional<google::protobuf::Arena> arena_;
    Reply reply_;
  };
};

/// What a message of ArenaMessages holds, roughly, at the cost of ByteSizeLong(): its arena, and
/// the text of strings, which are not on it.
inline std::size_t bytes_on_arena(const google::protobuf::Message& message) {
  return message.GetArena()->SpaceAllocated() + message.ByteSizeLong();
}

}  // namespace sightline::server::exec
