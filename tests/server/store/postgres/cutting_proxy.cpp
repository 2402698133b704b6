// Stands between a store and PostgreSQL, and cuts connections at the worst moments.
#include "tests/server/store/postgres/cutting_proxy.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <string>
#include <string_view>

#include "tests/server/store/postgres/postgres_server.h"

namespace sightline::tests {
namespace {

constexpr int kPollMilliseconds = 20;

sockaddr_un address_of(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
  return address;
}

int connect_to(const std::filesystem::path& path) {
  const int server = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_un address = address_of(path);
  if (connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0)
    return server;
  close(server);
  return -1;
}

/// What has arrived; empty at the end.
std::string read_some(int from) {
  std::array<char, 65536> buffer;
  const ssize_t size = read(from, buffer.data(), buffer.size());
  return size > 0 ? std::string(buffer.data(), static_cast<std::size_t>(size)) : std::string();
}

bool write_all(int to, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t size = send(to, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (size <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(size));
  }
  return true;
}

/// A message that is a simple query of just this.
bool is_commit(const std::string& bytes) {
  return bytes == std::string(
                      "Q\0\0\0\x0b"
                      "COMMIT\0",
                      12);
}

}  // namespace

CuttingProxy::CuttingProxy(const std::filesystem::path& server) : server_(server) {
  listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_un address = address_of(sockets() / PostgresServer::socket_name());
  EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  EXPECT_EQ(listen(listener_, 16), 0);
  acceptor_ = std::thread([this] { accept_all(); });
}

CuttingProxy::~CuttingProxy() {
  ending_ = true;
  acceptor_.join();
  close(listener_);
}

void CuttingProxy::accept_all() {
  while (!ending_) {
    pollfd waiting{listener_, POLLIN, 0};
    if (poll(&waiting, 1, kPollMilliseconds) <= 0) continue;
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (refuse_) {
      close(client);
    } else {
      forwarders_.emplace_back([this, client] { forward(client); });
    }
  }
  for (std::thread& forwarder : forwarders_) forwarder.join();
}

void CuttingProxy::forward(int client) {
  const int server = connect_to(server_);
  bool is_writer = false;
  while (!ending_ && server >= 0) {
    std::array<pollfd, 2> both{{{client, POLLIN, 0}, {server, POLLIN, 0}}};
    if (poll(both.data(), both.size(), kPollMilliseconds) <= 0) continue;
    if (both[0].revents != 0) {
      const std::string asked = read_some(client);
      is_writer = is_writer || asked.find("INSERT INTO writer") != std::string::npos;
      const Cut cut = is_writer && is_commit(asked) ? cut_.exchange(Cut::kNone) : Cut::kNone;
      if (asked.empty() || cut == Cut::kBeforeCommit || !write_all(server, asked)) break;
      if (cut == Cut::kAfterCommit) {
        (void)read_some(server);
        break;
      }
    }
    if (both[1].revents != 0) {
      const std::string answered = read_some(server);
      if (answered.empty() || !write_all(client, answered)) break;
    }
  }
  if (server >= 0) close(server);
  close(client);
}

}  // namespace sightline::tests
