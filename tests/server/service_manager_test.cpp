// Messages to the service manager.
#include "server/service_manager.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <string>

#include "server/net/descriptor.h"
#include "tests/support/child_process.h"

namespace sightline::server {
namespace {

/// A service manager that a test starts programs under.
class Manager {
 public:
  Manager() : socket_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const std::string name = "@sightline-test-" + std::to_string(getpid());
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path + 1, name.data() + 1, name.size() - 1);
    EXPECT_EQ(bind(socket_.number(), reinterpret_cast<const sockaddr*>(&address),
                   static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size())),
              0);
    setenv("NOTIFY_SOCKET", name.c_str(), 1);
  }
  ~Manager() { unsetenv("NOTIFY_SOCKET"); }

  /// Waits for the next message.
  std::string next() const {
    std::array<char, 64> got{};
    const auto bytes = recv(socket_.number(), got.data(), got.size(), 0);
    return {got.data(), static_cast<std::size_t>(bytes > 0 ? bytes : 0)};
  }

 private:
  const net::Descriptor socket_;
};

TEST(ServiceManager, GetsTheState) {
  const Manager manager;
  tell_service_manager("READY=1");
  EXPECT_EQ(manager.next(), "READY=1");
}

TEST(ServiceManager, HearsWhenTheServerServesAndWhenItStops) {
  const Manager manager;
  tests::ChildProcess child(SIGHTLINED, {"--listen", "127.0.0.1:0", "--threads", "1"});
  EXPECT_EQ(manager.next(), "READY=1");
  child.signal(SIGTERM);
  EXPECT_EQ(manager.next(), "STOPPING=1");
  EXPECT_EQ(child.wait(), 0);
}

TEST(ServiceManager, MayBeAbsentOrGone) {
  unsetenv("NOTIFY_SOCKET");
  tell_service_manager("READY=1");
  for (const std::string& path :
       {std::string("/nowhere/socket"), std::string("relative"), "@" + std::string(200, 'a')}) {
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
    tell_service_manager("READY=1");
  }
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace sightline::server
