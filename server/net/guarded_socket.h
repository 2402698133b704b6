// One guarded connection, between the calls that read and write it.
#pragma once

#include <sys/uio.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include "server/net/ended_connections.h"
#include "server/net/frame_guard.h"

namespace sightline::server::net {

/// Threads: any, for every member; one at a time reads, and one writes.
class GuardedSocket {
 public:
  using Bytes = std::span<const std::uint8_t>;
  using Buffers = std::span<const iovec>;

  /// `socket`: stays open as long as this is used.
  GuardedSocket(int socket, std::size_t max_streams, std::shared_ptr<EndedConnections> ended);

  /// `size` bytes have come into the buffers. Returns how many bytes are in them now: those, or
  /// fewer and PING frames behind them.
  std::size_t received(Buffers buffers, std::size_t size);
  /// Call it before anything is read. Returns how many bytes it has put into the buffers instead of
  /// what the client sends. 0: nothing comes any more. None: read.
  std::optional<std::size_t> instead(Buffers buffers);

  /// Whether nothing comes any more.
  bool is_over();

  /// Call it before bytes are written.
  void sending(Buffers buffers);
  /// Call it when `size` bytes of them were written; the others will come again. Less than 0: none.
  void sent(std::ptrdiff_t size);

 private:
  std::size_t put_pings(Buffers buffers, std::size_t from);
  void end(Abuse abuse);

  const int socket_;
  const std::shared_ptr<EndedConnections> ended_;
  std::mutex mutex_;
  FrameGuard guard_;
  std::size_t seen_ = 0, begun_ = 0;  // bytes that come again, and those of this write
  bool ends_ = false;
  std::size_t pings_put_ = 0;  // bytes
};

}  // namespace sightline::server::net
