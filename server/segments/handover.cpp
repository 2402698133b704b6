// The Unix socket at which clients get the descriptors of segments.
#include "server/segments/handover.h"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <exception>
#include <map>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "server/net/peer_address.h"
#include "server/segments/random_bytes.h"

namespace sightline::server::segments {
namespace {

/// Connections that are accepted before those that wait are looked at.
constexpr int kAtOnce = 16;
/// Connections that wait to be accepted: a client's connect() waits beyond that.
constexpr int kBacklog = 64;
/// The pause where nothing can be accepted for want of descriptors or memory.
constexpr std::chrono::milliseconds kPause{10};

net::Descriptor must(int made, const char* what) {
  if (made < 0) throw std::system_error(errno, std::generic_category(), what);
  return net::Descriptor(made);
}

net::Descriptor listen_at(const std::string& name) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  static_assert(sizeof address.sun_path > 64);
  name.copy(address.sun_path + 1, sizeof address.sun_path - 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  net::Descriptor made =
      must(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0), "socket");
  if (bind(made.number(), reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      listen(made.number(), kBacklog) != 0)
    throw std::system_error(errno, std::generic_category(), "bind");
  return made;
}

/// One byte with a descriptor, which the room of a new connection takes. Returns whether it did.
bool send_descriptor(int connection, int descriptor) {
  char byte = 0;
  iovec data{&byte, 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof descriptor)> control{};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const rights = CMSG_FIRSTHDR(&message);
  rights->cmsg_level = SOL_SOCKET;
  rights->cmsg_type = SCM_RIGHTS;
  rights->cmsg_len = CMSG_LEN(sizeof descriptor);
  std::memcpy(CMSG_DATA(rights), &descriptor, sizeof descriptor);
  return sendmsg(connection, &message, MSG_NOSIGNAL | MSG_DONTWAIT) == 1;
}

/// Lets the peer send nothing more, and drops what it has sent. A peer could have sent a descriptor
/// of its own end, which would keep the connection open when the peer is gone.
void refuse_input(int connection) {
  shutdown(connection, SHUT_RD);
  std::array<char, 4096> dropped{};
  while (recv(connection, dropped.data(), dropped.size(), MSG_DONTWAIT) > 0) {
  }
}

}  // namespace

Handover::Handover(HandoverKeys& keys)
    : keys_(keys),
      name_("sightline-segments-" + random_name()),
      listener_(listen_at(name_)),
      wake_(must(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), "eventfd")),
      thread_([this] {
        try {
          run();
        } catch (const std::exception& thrown) {
          spdlog::error("event=handover_failed reason=\"{}\"", thrown.what());
          listener_ = net::Descriptor();  // clients are refused, instead of waiting
        }
      }) {}

Handover::~Handover() {
  eventfd_write(wake_.number(), 1);
  thread_.join();
}

void Handover::run() {
  std::vector<pollfd> polled;
  for (;;) {
    polled.assign({{wake_.number(), POLLIN, 0}, {listener_.number(), POLLIN, 0}});
    for (const Waiting& one : waiting_) polled.push_back({one.connection.number(), POLLIN, 0});
    // Of these only the end is told.
    for (const Served& one : served_) polled.push_back({one.connection.number(), 0, 0});
    if (poll(polled.data(), polled.size(), wait_ms()) < 0 && errno != EINTR)
      throw std::system_error(errno, std::generic_category(), "poll");
    if (polled[0].revents != 0) return;
    let_go(std::span(polled).last(served_.size()));
    const auto now = Clock::now();
    std::erase_if(waiting_, [&](Waiting& one) { return serve(one) || one.until <= now; });
    if (polled[1].revents != 0) accept_some();
  }
}

/// Until the oldest connection has waited for too long; -1: none waits.
int Handover::wait_ms() const {
  if (waiting_.empty()) return -1;
  const auto left = waiting_.front().until - Clock::now();
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(left).count();
  return static_cast<int>(std::max<std::int64_t>(ms, 0));
}

void Handover::accept_some() {
  for (int i = 0; i < kAtOnce; ++i) {
    net::Descriptor connection(
        accept4(listener_.number(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (connection) {
      take(std::move(connection));
      continue;
    }
    // An error that stays would make poll() return at once, again and again.
    if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED)
      std::this_thread::sleep_for(kPause);
    return;
  }
}

void Handover::take(net::Descriptor connection) try {
  Waiting one{std::move(connection), {}, Clock::now() + kKeyTimeout};
  if (serve(one)) return;
  one.user = net::address_of(one.connection.number());
  if (waiting_.size() >= kMaxWaiting) close_oldest_for(one.user);
  waiting_.push_back(std::move(one));
} catch (const std::exception& thrown) {
  spdlog::warn("event=handover_refused reason=\"{}\"", thrown.what());
}

/// Reads the bytes of the key that are there, and answers if that is all of it. Returns whether the
/// connection waits no longer.
bool Handover::serve(Waiting& one) {
  const std::span left = std::span(one.key).subspan(one.received);
  const ssize_t size = recv(one.connection.number(), left.data(), left.size(), MSG_DONTWAIT);
  if (size < 0) return errno != EAGAIN && errno != EINTR;
  if (size == 0) return true;
  one.received += static_cast<std::size_t>(size);
  if (one.received < one.key.size()) return false;
  auto segment = keys_.take(one.key);
  if (segment == nullptr) return true;
  served_.push_back({std::move(one.connection), std::move(segment)});
  const Served& served = served_.back();
  refuse_input(served.connection.number());
  if (!send_descriptor(served.connection.number(), served.segment->descriptor()))
    served_.pop_back();
  return true;
}

/// Forgets the clients that have closed their connections. Segments whose calls have ended end with
/// them.
void Handover::let_go(std::span<const pollfd> of_served) {
  auto polled = of_served.begin();
  std::erase_if(served_, [&](const Served& one) {
    if ((polled++)->revents == 0) return false;
    one.segment->note_client_gone();
    return true;
  });
}

/// Closes the oldest connection of the user who has most, the new one's included.
void Handover::close_oldest_for(const std::string& user) {
  std::map<std::string_view, std::size_t> counts{{user, 1}};
  for (const Waiting& one : waiting_) ++counts[one.user];
  const auto most =
      std::ranges::max_element(counts, {}, [](const auto& of_user) { return of_user.second; });
  const auto oldest =
      std::ranges::find_if(waiting_, [&](const Waiting& one) { return one.user == most->first; });
  waiting_.erase(oldest == waiting_.end() ? waiting_.begin() : oldest);
}

}  // namespace sightline::server::segments
