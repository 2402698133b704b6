// What a client takes from the socket of a server, and what it refuses.
#include "client/calls/segment_handover.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace sightline::client::calls {
namespace {

constexpr std::uint64_t kBytes = 8192;
const std::string kKey(32, 'k');

std::chrono::system_clock::time_point soon() {
  return std::chrono::system_clock::now() + std::chrono::minutes(1);
}

int make_memfd(std::uint64_t bytes, bool is_sealed) {
  const int file = memfd_create("segment", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  EXPECT_EQ(ftruncate(file, static_cast<off_t>(bytes)), 0);
  if (is_sealed) {
    EXPECT_EQ(fcntl(file, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW), 0);
  }
  return file;
}

void send_descriptors(int socket, const std::vector<int>& files) {
  char byte = 0;
  iovec data{.iov_base = &byte, .iov_len = 1};
  std::vector<char> control(CMSG_SPACE(files.size() * sizeof(int)));
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  if (!files.empty()) {
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* const part = CMSG_FIRSTHDR(&message);
    part->cmsg_level = SOL_SOCKET;
    part->cmsg_type = SCM_RIGHTS;
    part->cmsg_len = CMSG_LEN(files.size() * sizeof(int));
    std::memcpy(CMSG_DATA(part), files.data(), files.size() * sizeof(int));
  }
  EXPECT_EQ(sendmsg(socket, &message, MSG_NOSIGNAL), 1);
}

/// Listens at an abstract name that the system chooses, and gives its one caller what `serve`
/// sends.
class Handover {
 public:
  explicit Handover(std::function<void(int)> serve) : listener_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof(sa_family_t)), 0);
    socklen_t size = sizeof address;
    EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    name_.assign(address.sun_path + 1, size - offsetof(sockaddr_un, sun_path) - 1);
    EXPECT_EQ(listen(listener_, 1), 0);
    thread_ = std::thread([this, serve = std::move(serve)] {
      const int caller = accept(listener_, nullptr, nullptr);
      if (caller < 0) return;
      std::string key(kKey.size(), '\0');
      EXPECT_EQ(recv(caller, key.data(), key.size(), MSG_WAITALL),
                static_cast<ssize_t>(key.size()));
      EXPECT_EQ(key, kKey);
      serve(caller);
      close(caller);
    });
  }
  ~Handover() {
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
  }

  const std::string& name() const { return name_; }

 private:
  int listener_;
  std::string name_;
  std::thread thread_;
};

TEST(SegmentHandover, MapsWhatComes) {
  const int file = make_memfd(kBytes, true);
  const Handover handover([&](int caller) { send_descriptors(caller, {file}); });
  const auto memory = receive_segment(handover.name(), kKey, kBytes, soon());
  ASSERT_TRUE(memory) << memory.error().message;
  EXPECT_EQ(memory->memory.size(), kBytes);
  EXPECT_FALSE(memory->server.has_ended(std::chrono::milliseconds(0))) << "it is this process";
  memory->memory.data()[kBytes - 1] = std::byte{42};
  char last = 0;
  EXPECT_EQ(pread(file, &last, 1, kBytes - 1), 1);
  EXPECT_EQ(last, 42) << "the memory is shared";
  close(file);
}

/// Returns when the client has closed its end, having sent nothing more.
void expect_end(int caller) {
  char byte = 0;
  EXPECT_EQ(recv(caller, &byte, 1, 0), 0);
}

TEST(SegmentHandover, KeepsTheConnectionAsLongAsTheMemory) {
  const int file = make_memfd(kBytes, true);
  std::atomic<bool> is_closed = false;
  std::optional<Handover> handover(std::in_place, [&](int caller) {
    send_descriptors(caller, {file});
    expect_end(caller);
    is_closed = true;
  });
  {
    auto received = receive_segment(handover->name(), kKey, kBytes, soon());
    ASSERT_TRUE(received) << received.error().message;
    const auto all = std::make_unique<ReceivedSegment>(*std::move(received));
    EXPECT_FALSE(is_closed);
    EXPECT_NE(fcntl(all->connection.number(), F_GETFD) & FD_CLOEXEC, 0);
  }
  handover.reset();
  EXPECT_TRUE(is_closed);
  close(file);
}

TEST(SegmentHandover, TellsWhenTheServerHasEnded) {
  int ends[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    // Whose process it is shows at a socket that the child has made.
    const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    socklen_t size = sizeof address;
    if (bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof(sa_family_t)) != 0 ||
        listen(listener, 1) != 0 ||
        getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
        send(ends[1], address.sun_path, 6, 0) != 6)
      _exit(1);
    pause();
    _exit(0);
  }
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_EQ(recv(ends[0], address.sun_path, 6, MSG_WAITALL), 6) << "five digits behind a zero";
  const int connection = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(connect(connection, reinterpret_cast<sockaddr*>(&address), sizeof(sa_family_t) + 6), 0);
  const ServerProcess server = ServerProcess::of_peer(connection);
  EXPECT_FALSE(server.has_ended(std::chrono::milliseconds(0)));
  EXPECT_FALSE(ServerProcess().has_ended(std::chrono::milliseconds(0)));
  kill(child, SIGKILL);
  EXPECT_TRUE(server.has_ended(std::chrono::minutes(1)));
  waitpid(child, nullptr, 0);
  for (const int file : {connection, ends[0], ends[1]}) close(file);
}

TEST(SegmentHandover, RefusesWhatCouldEndTheProcess) {
  const int large = make_memfd(kBytes, true), small = make_memfd(kBytes - 1, true),
            open = make_memfd(kBytes, false);
  for (const std::vector<int>& files :
       {std::vector<int>{small}, {open}, {STDIN_FILENO}, {}, {large, large}}) {
    const Handover handover([&](int caller) {
      send_descriptors(caller, files);
      expect_end(caller);
    });
    const auto memory = receive_segment(handover.name(), kKey, kBytes, soon());
    ASSERT_FALSE(memory);
    EXPECT_EQ(memory.error().code, Code::kUnavailable) << memory.error().message;
  }
  for (const int file : {large, small, open}) close(file);
}

TEST(SegmentHandover, ASocketThatIsNotThereOrSaysNothing) {
  std::string name;
  {
    const Handover handover([](int) {});
    name = handover.name();
    EXPECT_EQ(receive_segment(name, kKey, kBytes, soon()).error().code, Code::kUnavailable);
  }
  const auto gone = receive_segment(name, kKey, kBytes, soon());
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().code, Code::kUnavailable);
  EXPECT_NE(gone.error().message.find("cannot be reached"), std::string::npos);
}

TEST(SegmentHandover, ADeadlineEndsTheWait) {
  const Handover handover(expect_end);
  const auto late = receive_segment(handover.name(), kKey, kBytes,
                                    std::chrono::system_clock::now() - std::chrono::hours(1));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, Code::kUnavailable);
}

TEST(SegmentHandover, NamesAndKeysOfAnotherForm) {
  for (const auto& [name, key] : std::vector<std::pair<std::string, std::string>>{
           {"", kKey}, {std::string(108, 'n'), kKey}, {"name", kKey + "k"}, {"name", ""}})
    EXPECT_EQ(receive_segment(name, key, kBytes, soon()).error().code, Code::kInternal);
}

}  // namespace
}  // namespace sightline::client::calls
