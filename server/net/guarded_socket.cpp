// One guarded connection, between the calls that read and write it.
#include "server/net/guarded_socket.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>

#include "server/net/peer_address.h"

namespace sightline::server::net {
namespace {

/// gRPC strikes at the fourth PING frame at the latest, and forgets the earlier ones when it
/// writes.
constexpr std::array<std::uint8_t, 17> kPing{0, 0, 8, FrameHead::kPing};
constexpr std::size_t kPings = 8 * kPing.size();

/// How long a connection that ends may wait for a client that does not read.
constexpr unsigned kEndMilliseconds = 2'000;

/// The time, a few milliseconds late: much cheaper than the clock's own now().
FrameGuard::Clock::time_point coarse_now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC_COARSE, &time);
  return FrameGuard::Clock::time_point(std::chrono::seconds(time.tv_sec) +
                                       std::chrono::nanoseconds(time.tv_nsec));
}

std::span<std::uint8_t> bytes_of(const iovec& buffer) {
  return {static_cast<std::uint8_t*>(buffer.iov_base), buffer.iov_len};
}

}  // namespace

GuardedSocket::GuardedSocket(int socket, std::size_t max_streams,
                             std::shared_ptr<EndedConnections> ended)
    : socket_(socket), ended_(std::move(ended)), guard_(max_streams, coarse_now()) {}

std::size_t GuardedSocket::received(Buffers buffers, std::size_t size) {
  const std::lock_guard lock(mutex_);
  const auto now = coarse_now();
  std::size_t before = 0;
  for (const iovec& buffer : buffers) {
    const auto bytes = bytes_of(buffer).first(std::min(buffer.iov_len, size - before));
    if (const auto verdict = guard_.receive(bytes, now)) {
      end(verdict->abuse);
      return put_pings(buffers, before + verdict->at);
    }
    before += bytes.size();
  }
  return size;
}

std::optional<std::size_t> GuardedSocket::instead(Buffers buffers) {
  const std::lock_guard lock(mutex_);
  if (!ends_) return std::nullopt;
  return put_pings(buffers, 0);
}

bool GuardedSocket::is_over() {
  const std::lock_guard lock(mutex_);
  return ends_ && pings_put_ == kPings;
}

/// Puts PING frames behind the first `from` bytes. Returns the size of all.
std::size_t GuardedSocket::put_pings(Buffers buffers, std::size_t from) {
  std::size_t before = 0;
  for (const iovec& buffer : buffers) {
    const auto bytes = bytes_of(buffer);
    for (std::size_t i = from - std::min(from, before); i < bytes.size() && pings_put_ < kPings;
         ++i, ++from)
      bytes[i] = kPing[pings_put_++ % kPing.size()];
    before += bytes.size();
  }
  return from;
}

void GuardedSocket::end(Abuse abuse) {
  ends_ = true;
  const unsigned limit = kEndMilliseconds;
  setsockopt(socket_, IPPROTO_TCP, TCP_USER_TIMEOUT, &limit, sizeof limit);
  ended_->add(abuse, address_of(socket_));
}

void GuardedSocket::sending(Buffers buffers) {
  const std::lock_guard lock(mutex_);
  const auto now = coarse_now();
  std::size_t again = seen_;
  begun_ = 0;
  for (const iovec& buffer : buffers) {
    const Bytes bytes = bytes_of(buffer);
    const std::size_t known = std::min(again, bytes.size());
    again -= known;
    begun_ += bytes.size();
    guard_.send(bytes.subspan(known), now);
  }
  seen_ = std::max(seen_, begun_);
}

void GuardedSocket::sent(std::ptrdiff_t size) {
  const std::lock_guard lock(mutex_);
  if (size > 0) seen_ -= std::min(seen_, static_cast<std::size_t>(size));
}

}  // namespace sightline::server::net
