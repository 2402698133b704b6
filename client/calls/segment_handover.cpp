// A descriptor that comes over a Unix socket.
#include "client/calls/segment_handover.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include "client/calls/descriptor.h"

namespace sightline::client::calls {
namespace {

constexpr std::size_t kKeyBytes = 32;

Error unavailable(const std::string& what) { return {Code::kUnavailable, what, {}}; }

Error failed(const char* what) {
  return unavailable(fmt::format("{}: {}", what, std::system_category().message(errno)));
}

/// The system call, again while signals interrupt it.
template <class Call>
auto restarted(const Call& call) {
  while (true) {
    const auto result = call();
    if (result >= 0 || errno != EINTR) return result;
  }
}

/// Lets calls on the socket end at the deadline. They take at least a millisecond, as 0 is no
/// bound.
void bound(int socket, std::chrono::system_clock::time_point deadline) {
  using std::chrono::microseconds;
  const auto rest = std::clamp(
      std::chrono::duration_cast<microseconds>(deadline - std::chrono::system_clock::now()),
      microseconds(1000), microseconds(std::chrono::minutes(1)));
  const timeval time{.tv_sec = rest.count() / 1'000'000, .tv_usec = rest.count() % 1'000'000};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &time, sizeof time);
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &time, sizeof time);
}

Result<Descriptor> connect_to(const std::string& name,
                              std::chrono::system_clock::time_point deadline) {
  Descriptor connection(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!connection) return failed("no socket for a segment");
  bound(connection.number(), deadline);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (restarted([&] {
        return connect(connection.number(), reinterpret_cast<const sockaddr*>(&address), size);
      }) < 0)
    return failed("the server's socket for segments cannot be reached");
  return connection;
}

/// The descriptor that comes with one byte. More than one are closed, and refused.
Result<Descriptor> receive(int socket) {
  constexpr std::size_t kMost = 4;
  char byte = 0;
  iovec data{.iov_base = &byte, .iov_len = 1};
  alignas(cmsghdr) char control[CMSG_SPACE(kMost * sizeof(int))];
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t got = restarted([&] { return recvmsg(socket, &message, MSG_CMSG_CLOEXEC); });
  if (got < 0) return failed("the server has not sent the segment");
  std::size_t count = 0;
  Descriptor first;
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t numbers = (part->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < numbers; ++i) {
      int number = -1;
      std::memcpy(&number, CMSG_DATA(part) + i * sizeof number, sizeof number);
      Descriptor received(number);
      if (count++ == 0) first = std::move(received);
    }
  }
  if (count == 1) return first;
  return unavailable(
      fmt::format("the server has sent {} descriptors instead of that of the segment", count));
}

}  // namespace

void Mapping::Unmap::operator()(std::byte* data) const { munmap(data, bytes); }

Result<Mapping> Mapping::map(int descriptor, std::uint64_t bytes, int flags) {
  void* data = MAP_FAILED;
  if (bytes > 0 && bytes <= std::numeric_limits<std::ptrdiff_t>::max())
    data = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, flags, descriptor, 0);
  if (data == MAP_FAILED) {
    return Error{
        Code::kResourceExhausted, fmt::format("{} bytes of memory cannot be mapped", bytes), {}};
  }
  Mapping mapping;
  mapping.data_ = {static_cast<std::byte*>(data), Unmap{bytes}};
  return mapping;
}

Result<Mapping> Mapping::anonymous(std::uint64_t bytes) {
  return map(-1, bytes, MAP_PRIVATE | MAP_ANONYMOUS);
}

Result<Mapping> Mapping::of_segment(int descriptor, std::uint64_t bytes) {
  struct stat file {};
  if (fstat(descriptor, &file) != 0) return failed("the segment has no size");
  if (file.st_size < 0 || static_cast<std::uint64_t>(file.st_size) < bytes) {
    return unavailable(fmt::format("the segment has {} bytes instead of {}", file.st_size, bytes));
  }
  const int seals = fcntl(descriptor, F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0)
    return unavailable("the segment is not sealed against shrinking");
  return map(descriptor, bytes, MAP_SHARED);
}

Result<ReceivedSegment> receive_segment(const std::string& socket, const std::string& key,
                                        std::uint64_t bytes,
                                        std::chrono::system_clock::time_point deadline) {
  constexpr std::size_t kLongestName = sizeof(sockaddr_un::sun_path) - 1;
  if (socket.empty() || socket.size() > kLongestName || key.size() != kKeyBytes) {
    return Error{Code::kInternal,
                 fmt::format("the server's name of a socket has {} bytes instead of up to {}, or "
                             "its key {} instead of {}",
                             socket.size(), kLongestName, key.size(), kKeyBytes),
                 {}};
  }
  auto connection = connect_to(socket, deadline);
  if (!connection) return connection.error();
  const ssize_t sent =
      restarted([&] { return send(connection->number(), key.data(), key.size(), MSG_NOSIGNAL); });
  if (sent < 0) return failed("the key of a segment cannot be sent");
  if (static_cast<std::size_t>(sent) != key.size())
    return unavailable("the key of a segment was not taken as a whole");
  const auto segment = receive(connection->number());
  if (!segment) return segment.error();
  auto memory = Mapping::of_segment(segment->number(), bytes);
  if (!memory) return memory.error();
  auto server = ServerProcess::of_peer(connection->number());
  return ReceivedSegment{*std::move(connection), *std::move(memory), std::move(server)};
}

}  // namespace sightline::client::calls
