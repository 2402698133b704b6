// Sockets that listen.
#include "server/net/listening_sockets.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

namespace sightline::server::net {
namespace {

struct Free {
  void operator()(addrinfo* list) const { freeaddrinfo(list); }
};
using AddressList = std::unique_ptr<addrinfo, Free>;

Error unavailable(const ListenAddress& address, const std::string& why) {
  return {Code::kUnavailable, fmt::format("cannot listen on {}: {}", address.text(), why),
          "PORT_UNAVAILABLE"};
}

Result<AddressList> resolve(const ListenAddress& address) {
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(address.port);
  const int failed = getaddrinfo(address.host.c_str(), port.c_str(), &hints, &found);
  if (failed != 0) return unavailable(address, gai_strerror(failed));
  return AddressList(found);
}

/// `port` replaces the port of the address. Empty if it fails; errno says why.
Descriptor listen_on(const addrinfo& entry, std::uint16_t port) {
  sockaddr_storage address{};
  std::memcpy(&address, entry.ai_addr, entry.ai_addrlen);
  if (entry.ai_family == AF_INET) {
    reinterpret_cast<sockaddr_in&>(address).sin_port = htons(port);
  } else {
    reinterpret_cast<sockaddr_in6&>(address).sin6_port = htons(port);
  }
  Descriptor made(socket(entry.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  const bool listens =
      made && setsockopt(made.number(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
      bind(made.number(), reinterpret_cast<const sockaddr*>(&address), entry.ai_addrlen) == 0 &&
      listen(made.number(), SOMAXCONN) == 0;
  return listens ? std::move(made) : Descriptor();
}

std::uint16_t port_of(const Descriptor& listening) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  getsockname(listening.number(), reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET ? reinterpret_cast<sockaddr_in&>(address).sin_port
                                            : reinterpret_cast<sockaddr_in6&>(address).sin6_port);
}

/// Read and write for the owner and the group: to connect takes the right to write.
constexpr mode_t kSocketMode = 0660;

/// Whether the path is a socket at which no process listens any more.
bool is_left_behind(const sockaddr_un& address) {
  struct stat found {};
  if (lstat(address.sun_path, &found) != 0 || !S_ISSOCK(found.st_mode)) return false;
  const Descriptor probe(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  return connect(probe.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) !=
             0 &&
         errno == ECONNREFUSED;
}

Result<ListeningSockets> listen_on_path(const ListenAddress& wanted) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  wanted.path.copy(address.sun_path, sizeof address.sun_path - 1);
  if (is_left_behind(address)) unlink(address.sun_path);
  Descriptor made(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  // The file of a socket is never open to all, whatever the umask: it has the socket's mode.
  const bool bound =
      made && fchmod(made.number(), kSocketMode) == 0 &&
      bind(made.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      chmod(address.sun_path, kSocketMode) == 0;
  if (!bound) return unavailable(wanted, std::generic_category().message(errno));
  ListeningSockets result{.sockets = {}, .port = 0, .file = SocketFile(wanted.path)};
  if (listen(made.number(), SOMAXCONN) != 0)
    return unavailable(wanted, std::generic_category().message(errno));
  result.sockets.push_back(std::move(made));
  return result;
}

}  // namespace

SocketFile::~SocketFile() {
  if (!path_.empty()) unlink(path_.c_str());
}

Result<ListeningSockets> listen_on(const ListenAddress& address) {
  if (address.is_unix()) return listen_on_path(address);
  const auto list = resolve(address);
  if (!list) return list.error();
  ListeningSockets result{.sockets = {}, .port = address.port};
  int failed = 0;
  for (const addrinfo* entry = list->get(); entry != nullptr; entry = entry->ai_next) {
    if (entry->ai_family != AF_INET && entry->ai_family != AF_INET6) continue;
    Descriptor made = listen_on(*entry, result.port);
    if (!made) {
      failed = errno;
      // A name's address that this machine does not have is no reason to refuse the others.
      if (failed == EADDRNOTAVAIL || failed == EAFNOSUPPORT) continue;
      return unavailable(address, std::generic_category().message(failed));
    }
    result.port = port_of(made);
    result.sockets.push_back(std::move(made));
  }
  if (result.sockets.empty()) return unavailable(address, std::generic_category().message(failed));
  return result;
}

}  // namespace sightline::server::net
