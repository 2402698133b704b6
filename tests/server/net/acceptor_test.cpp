// Accepting connections: at the limit, without file descriptors, and at the end.
#include "server/net/acceptor.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/net/listening_sockets.h"
#include "tests/server/support/tcp.h"

namespace sightline::server::net {
namespace {

using tests::connect_tcp, tests::receive_bytes;

const std::string kWelcome = "welcome";

class AcceptorTest : public testing::Test {
 protected:
  void start(std::size_t limit) {
    auto listening = listen_on({.host = "127.0.0.1", .port = 0});
    port_ = listening->port;
    acceptor_ = std::make_unique<Acceptor>(
        std::move(listening->sockets), limit,
        Acceptor::Events{.accepted =
                             [this](int, Descriptor connection) {
                               const std::lock_guard lock(mutex_);
                               tests::send_bytes(connection, kWelcome);
                               accepted_.push_back(std::move(connection));
                             },
                         .failed = [] { ADD_FAILURE(); },
                         .ended = [this] { return std::exchange(ended_, {}); }});
  }

  /// As gRPC ends a connection.
  void end_last() {
    const std::lock_guard lock(mutex_);
    shutdown(accepted_.back().number(), SHUT_RDWR);
    accepted_.pop_back();
  }

  int port_ = 0;
  std::vector<std::string> ended_;  // read while a connection waits
  std::mutex mutex_;
  std::vector<Descriptor> accepted_;
  std::unique_ptr<Acceptor> acceptor_;
};

TEST_F(AcceptorTest, ClosesAConnectionOverTheLimit) {
  start(1);
  const Descriptor first = connect_tcp(port_);
  EXPECT_EQ(receive_bytes(first), kWelcome);
  EXPECT_EQ(receive_bytes(connect_tcp(port_)), "");
}

TEST_F(AcceptorTest, AConnectionThatHasEndedDoesNotCount) {
  start(1);
  for (int i = 0; i < 10; ++i) {
    Descriptor client;
    do {
      client = connect_tcp(port_);  // refused until the end of the last one is noticed
    } while (receive_bytes(client).empty());
    end_last();
    EXPECT_EQ(receive_bytes(client), "");
  }
}

TEST_F(AcceptorTest, AnotherAddressGetsItsShare) {
  start(2);
  const Descriptor first = connect_tcp(port_), second = connect_tcp(port_);
  EXPECT_EQ(receive_bytes(first), kWelcome);
  EXPECT_EQ(receive_bytes(second), kWelcome);
  const Descriptor other = connect_tcp(port_, "127.0.0.2");
  EXPECT_EQ(receive_bytes(other), kWelcome);
  EXPECT_EQ(receive_bytes(second), "");
  EXPECT_EQ(receive_bytes(connect_tcp(port_)), "");
}

/// While it lives, this process opens no more files.
class NoMoreFiles {
 public:
  NoMoreFiles() {
    EXPECT_EQ(getrlimit(RLIMIT_NOFILE, &before_), 0);
    const Descriptor next(open("/dev/null", O_RDONLY | O_CLOEXEC));
    rlimit none = before_;
    none.rlim_cur = static_cast<rlim_t>(next.number());
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  }
  ~NoMoreFiles() { EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &before_), 0); }

 private:
  rlimit before_{};
};

TEST_F(AcceptorTest, AcceptsAgainAfterFileDescriptorsHaveRunOut) {
  start(100);
  std::vector<Descriptor> waiting;
  for (int i = 0; i < 2; ++i) waiting.emplace_back(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  {
    const NoMoreFiles none;
    for (const Descriptor& one : waiting) {
      tests::connect_tcp(one, port_);
      EXPECT_EQ(receive_bytes(one), "");
    }
  }
  const Descriptor client = connect_tcp(port_);
  EXPECT_EQ(receive_bytes(client), kWelcome);
}

TEST_F(AcceptorTest, ConnectionsOfOneAddressAreHandedOverAtAPace) {
  start(2'000);
  const auto began = std::chrono::steady_clock::now();
  std::vector<Descriptor> clients;
  for (std::uint64_t i = 0; i < 2 * Acceptor::kPerSecond; ++i)
    clients.push_back(connect_tcp(port_));
  const Descriptor other = connect_tcp(port_, "127.0.0.2");
  EXPECT_EQ(receive_bytes(other), kWelcome);
  clients.front() = Descriptor();  // a client that gives up
  for (std::size_t i = 1; i < clients.size(); ++i)
    ASSERT_EQ(receive_bytes(clients[i]), kWelcome) << i;
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(900));
}

TEST_F(AcceptorTest, AnAddressWhoseConnectionsWereEndedWaits) {
  ended_.assign(2 * Acceptor::kPerSecond / Acceptor::kPerEnded, "127.0.0.1");
  start(10);
  const auto began = std::chrono::steady_clock::now();
  const Descriptor other = connect_tcp(port_, "127.0.0.2");
  EXPECT_EQ(receive_bytes(other), kWelcome);
  const Descriptor client = connect_tcp(port_);
  EXPECT_EQ(receive_bytes(client), kWelcome);
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(900));
}

TEST_F(AcceptorTest, RefusesConnectionsAfterItsEnd) {
  start(2);
  const Descriptor client = connect_tcp(port_);
  EXPECT_EQ(receive_bytes(client), kWelcome);
  acceptor_->stop();
  acceptor_->stop();
  EXPECT_FALSE(tests::connect_tcp(Descriptor(socket(AF_INET, SOCK_STREAM, 0)), port_));
  tests::send_bytes(client, "still open");
  EXPECT_EQ(receive_bytes(accepted_[0]), "still open");
  acceptor_->shut_down();
  EXPECT_EQ(receive_bytes(client), "");
}

}  // namespace
}  // namespace sightline::server::net
