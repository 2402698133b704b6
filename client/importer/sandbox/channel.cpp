// Sequenced packets over a pair of sockets: a message arrives whole or not at all.
#include "client/importer/sandbox/channel.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace sightline::client::importer::sandbox {

Request Request::of(Kind kind, std::string_view text) {
  Request request;
  request.kind = kind;
  request.length = static_cast<std::uint16_t>(std::min(text.size(), request.text.size()));
  std::copy_n(text.begin(), request.length, request.text.begin());
  return request;
}

std::string_view Request::message() const {
  return {text.data(), std::min<std::size_t>(length, text.size())};
}

std::optional<Channel> open_channel() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) return {};
  return Channel{FileHandle(ends[0]), FileHandle(ends[1])};
}

bool send_bytes(int socket, const void* message, std::size_t size, int file) {
  iovec part{const_cast<void*>(message), size};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr packet{};
  packet.msg_iov = &part;
  packet.msg_iovlen = 1;
  if (file >= 0) {
    packet.msg_control = control.data();
    packet.msg_controllen = control.size();
    cmsghdr* const header = CMSG_FIRSTHDR(&packet);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(header), &file, sizeof(int));
  }
  ssize_t sent = 0;
  do {
    sent = ::sendmsg(socket, &packet, MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(size);
}

bool receive_bytes(int socket, void* message, std::size_t size, FileHandle* file) {
  iovec part{message, size};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr packet{};
  packet.msg_iov = &part;
  packet.msg_iovlen = 1;
  if (file != nullptr) {
    packet.msg_control = control.data();
    packet.msg_controllen = control.size();
  }
  ssize_t got = 0;
  do {
    got = ::recvmsg(socket, &packet, MSG_CMSG_CLOEXEC);
  } while (got < 0 && errno == EINTR);
  if (got != static_cast<ssize_t>(size)) return false;
  const cmsghdr* const header = file != nullptr ? CMSG_FIRSTHDR(&packet) : nullptr;
  if (header != nullptr && header->cmsg_level == SOL_SOCKET && header->cmsg_type == SCM_RIGHTS) {
    int descriptor = -1;
    std::memcpy(&descriptor, CMSG_DATA(header), sizeof(int));
    *file = FileHandle(descriptor);
  }
  return true;
}

}  // namespace sightline::client::importer::sandbox
