// One of the servers that answer for shards: how it is called, and whether it lives.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_set>
#include <vector>

#include "sightline/v1/query.grpc.pb.h"

namespace sightline::server::shards {

/// How often peers are pinged.
inline constexpr std::chrono::milliseconds kPingEvery{250};
/// Pings in a row without an answer after which a peer is lost.
inline constexpr std::uint32_t kPingsUntilLost = 8;
/// One of this many pings of a lost peer goes over a new connection, too.
inline constexpr std::uint32_t kPingsOfAttempt = 3;

/// Pings are calls of the standard health service, which no thread that traces answers, and have a
/// connection of their own. Pings are counted, not the time: a process that was stopped itself, or
/// gets no processor, does not take its peers for lost. Threads: any, for every member but ping(),
/// which is called by one at a time.
class Peer {
 public:
  /// Makes a channel that shares its connection with no other.
  using Connect = std::function<std::shared_ptr<grpc::Channel>()>;
  using Stub = v1::RayQueryService::Stub;
  using Context = std::shared_ptr<grpc::ClientContext>;

  Peer(std::string address, Connect connect);
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  /// Waits for the ends of its pings, which it cancels.
  ~Peer();

  const std::string& address() const { return address_; }

  /// Call it every kPingEvery. It notices that the peer is lost, and cancels its open calls.
  void ping();
  /// Pings without an answer since the last answer. The newest of them may still be answered.
  std::uint32_t unanswered() const;
  bool is_lost() const;

  /// The stub for a call that begins now and must end with end(). Null: the peer is lost.
  std::shared_ptr<Stub> begin(const Context& context);
  /// What the end of the call says: UNAVAILABLE if it was cancelled because the peer is lost.
  grpc::Status end(const Context& context, grpc::Status status);
  /// The status UNAVAILABLE, with the number of pings that it has not answered.
  grpc::Status lost_status() const;

 private:
  /// A connection for pings. It ends in ping() and at the end of this: gRPC's own thread, in which
  /// a ping ends, must not destroy the last channel of a process.
  struct Line {
    std::shared_ptr<grpc::Channel> channel;
    Context context{};  // the last ping's
    grpc::ByteBuffer request{}, reply{};
    bool open = false;  // it has no answer
  };
  using LinePointer = std::unique_ptr<Line>;

  LinePointer connect() const;
  void send(Line& line);
  void end_ping(Line& line, const grpc::Status& status);
  void hear();
  std::vector<Context> retire_lines(std::vector<LinePointer>& ended);
  grpc::Status lost_locked() const;

  const std::string address_;
  const Connect connect_;
  mutable std::mutex mutex_;  // protects all members below, and the lines
  std::shared_ptr<Stub> stub_;
  std::unordered_set<Context> calls_;
  LinePointer line_;
  LinePointer attempt_;  // while it is lost: the connection may be dead, and not know
  std::vector<LinePointer> retired_;
  std::uint32_t open_pings_ = 0;
  std::condition_variable ping_ended_;
  bool lost_ = false;
  std::uint32_t unanswered_ = 0;
  std::string failure_;  // the last ping's
};

}  // namespace sightline::server::shards
