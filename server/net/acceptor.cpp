// Accepts connections, whatever the process runs out of.
#include "server/net/acceptor.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <exception>
#include <iterator>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "server/net/peer_address.h"

namespace sightline::server::net {
namespace {

/// File descriptors that are not connections of clients: 80, and those of 64 segments, of the
/// connections by which their clients have them, and of 32 that ask for one.
constexpr std::size_t kOwnFiles = 240;
constexpr std::size_t kFilesPerConnection = 2;
constexpr std::size_t kMaxConnections = 10'000;

/// The time between looks at connections that wait.
constexpr std::chrono::milliseconds kLook{10};

/// When the paces of this many addresses are known, those that may connect at once again are
/// forgotten.
constexpr std::size_t kMaxPaces = 1'000;

/// The pause after a refusal for which no descriptor was left either.
constexpr std::chrono::milliseconds kPause{10};

Descriptor must(int made, const char* what) {
  if (made < 0) throw std::system_error(errno, std::generic_category(), what);
  return Descriptor(made);
}

Descriptor spare() { return Descriptor(open("/dev/null", O_RDONLY | O_CLOEXEC)); }

int accept_one(int listener) {
  return accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
}

}  // namespace

std::size_t connection_limit() {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) return 1;
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
  getrlimit(RLIMIT_NOFILE, &files);
  const auto open = static_cast<std::size_t>(files.rlim_cur);
  if (open <= kOwnFiles) return 1;
  return std::clamp((open - kOwnFiles) / kFilesPerConnection, std::size_t{1}, kMaxConnections);
}

Acceptor::Acceptor(std::vector<Descriptor> listeners, std::size_t limit, Events events)
    : listeners_(std::move(listeners)),
      events_(std::move(events)),
      connections_(limit),
      epoll_(must(epoll_create1(EPOLL_CLOEXEC), "epoll_create1")),
      wake_(must(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), "eventfd")),
      reserve_(spare()) {
  watch(wake_.number(), EPOLLIN);
  for (const Descriptor& listener : listeners_) watch(listener.number(), EPOLLIN);
  thread_ = std::thread([this] {
    try {
      run();
    } catch (const std::exception& thrown) {
      spdlog::error("event=acceptor_failed reason=\"{}\"", thrown.what());
      events_.failed();
    }
  });
}

Acceptor::~Acceptor() { stop(); }

void Acceptor::stop() {
  if (!thread_.joinable()) return;
  eventfd_write(wake_.number(), 1);
  thread_.join();
  listeners_.clear();
}

void Acceptor::watch(int descriptor, unsigned events) {
  epoll_event event{.events = events, .data = {.fd = descriptor}};
  if (epoll_ctl(epoll_.number(), EPOLL_CTL_ADD, descriptor, &event) != 0)
    throw std::system_error(errno, std::generic_category(), "epoll_ctl");
}

void Acceptor::run() {
  std::array<epoll_event, 64> ready{};
  for (;;) {
    const int count = epoll_wait(epoll_.number(), ready.data(), ready.size(),
                                 waiting_.empty() ? -1 : static_cast<int>(kLook.count()));
    if (count < 0 && errno != EINTR)
      throw std::system_error(errno, std::generic_category(), "epoll_wait");
    const auto events = std::span(ready).first(static_cast<std::size_t>(std::max(count, 0)));
    // First those that are gone: a new connection may get the number of one of them.
    for (const epoll_event& event : events) {
      if (event.data.fd == wake_.number()) return;
      if (!is_listener(event.data.fd)) drop(event.data.fd);
    }
    for (const epoll_event& event : events) {
      if (is_listener(event.data.fd)) accept_from(event.data.fd);
    }
    hand_over_waiting();
  }
}

bool Acceptor::is_listener(int descriptor) const {
  return std::any_of(listeners_.begin(), listeners_.end(),
                     [&](const Descriptor& one) { return one.number() == descriptor; });
}

/// Stops watching a connection. To close the descriptor is not enough: epoll watches the socket,
/// which gRPC may still hold.
void Acceptor::drop(int connection) {
  epoll_ctl(epoll_.number(), EPOLL_CTL_DEL, connection, nullptr);
  connections_.remove(connection);
  std::erase_if(waiting_, [&](const Waiting& one) { return one.number == connection; });
}

void Acceptor::accept_from(int listener) {
  Descriptor connection(accept_one(listener));
  if (connection) return take(listener, std::move(connection));
  switch (errno) {
    case EMFILE:
    case ENFILE:
    case ENOBUFS:
    case ENOMEM:
      return refuse_from(listener);
    case EBADF:
    case EINVAL:
    case ENOTSOCK:
      throw std::system_error(errno, std::generic_category(), "accept4");
    default:
      return;  // the connection ended before it was accepted
  }
}

void Acceptor::refuse_from(int listener) {
  reserve_ = Descriptor();
  const bool refused = static_cast<bool>(Descriptor(accept_one(listener)));
  reserve_ = spare();
  if (!refused) std::this_thread::sleep_for(kPause);
}

void Acceptor::take(int listener, Descriptor connection) try {
  const std::string address = address_of(connection.number());
  if (connections_.full()) {
    const auto loser = connections_.gives_way_to(address);
    spdlog::debug("event=connection_refused peer={} open={} gives_way={}", address,
                  connections_.size(), loser.has_value());
    if (!loser) return;
    shutdown(*loser, SHUT_RDWR);
    drop(*loser);
  }
  const int on = 1;
  setsockopt(connection.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  Descriptor second(fcntl(connection.number(), F_DUPFD_CLOEXEC, 0));
  if (!second) return;
  watch(second.number(), 0);
  waiting_.push_back({listener, second.number(), address, std::move(connection)});
  connections_.add(address, std::move(second));
} catch (const std::exception& thrown) {
  spdlog::warn("event=connection_refused reason=\"{}\"", thrown.what());
}

void Acceptor::hand_over_waiting() try {
  const auto now = exec::TokenBucket::Clock::now();
  if (events_.ended) {
    for (const std::string& address : events_.ended()) {
      exec::TokenBucket& pace = pace_of(address);
      if (pace.wait(now) < kLongestWait) pace.take(kPerEnded);
    }
  }
  for (auto one = waiting_.begin(); one != waiting_.end();) {
    exec::TokenBucket& pace = pace_of(one->address);
    if (!pace.open(now)) {
      ++one;
      continue;
    }
    pace.take(1);
    events_.accepted(one->listener, std::move(one->connection));
    one = waiting_.erase(one);
  }
} catch (const std::exception& thrown) {
  spdlog::warn("event=connections_wait reason=\"{}\"", thrown.what());
}

exec::TokenBucket& Acceptor::pace_of(const std::string& address) {
  const auto now = exec::TokenBucket::Clock::now();
  if (paces_.size() > kMaxPaces) {
    for (auto pace = paces_.begin(); pace != paces_.end();)
      pace = pace->second.full(now) ? paces_.erase(pace) : std::next(pace);
  }
  return paces_.try_emplace(address, kPerSecond, now).first->second;
}

}  // namespace sightline::server::net
