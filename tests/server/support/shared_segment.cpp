// A segment of a server, as its client sees it.
#include "tests/server/support/shared_segment.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <utility>

namespace sightline::tests {

using server::net::Descriptor;

Descriptor connect_abstract(const std::string& name) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  name.copy(address.sun_path + 1, sizeof address.sun_path - 1);
  Descriptor made(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  EXPECT_EQ(connect(made.number(), reinterpret_cast<const sockaddr*>(&address), size), 0);
  return made;
}

TakenSegment take_segment(const std::string& socket, const std::string& key) {
  Descriptor connection = connect_abstract(socket);
  send(connection.number(), key.data(), key.size(), MSG_NOSIGNAL);
  char byte = 1;
  iovec data{&byte, 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  if (recvmsg(connection.number(), &message, MSG_CMSG_CLOEXEC) != 1) return {};
  const cmsghdr* rights = CMSG_FIRSTHDR(&message);
  if (rights == nullptr || rights->cmsg_type != SCM_RIGHTS) return {};
  int descriptor = -1;
  std::memcpy(&descriptor, CMSG_DATA(rights), sizeof descriptor);
  EXPECT_EQ(byte, 0);
  return {std::move(connection), Descriptor(descriptor)};
}

std::uint64_t pages_of(int descriptor) {
  struct stat found {};
  EXPECT_EQ(fstat(descriptor, &found), 0);
  return static_cast<std::uint64_t>(found.st_blocks) * 512 /
         static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

SegmentCall::SegmentCall(v1::RayQueryService::Stub& rays, std::uint64_t bytes) {
  v1::OpenSegmentRequest request;
  request.set_bytes(bytes);
  reader_ = rays.OpenSegment(&context_, request);
  open_ = reader_->Read(&response_);
}

SegmentCall::~SegmentCall() { end(); }

grpc::Status SegmentCall::wait() {
  v1::OpenSegmentResponse more;
  if (!ended_) {
    EXPECT_FALSE(reader_->Read(&more)) << "only one response comes";
    status_ = reader_->Finish();
  }
  ended_ = true;
  return status_;
}

grpc::Status SegmentCall::end() {
  if (open_) context_.TryCancel();
  return wait();
}

SharedSegment::SharedSegment(v1::RayQueryService::Stub& rays, std::uint64_t bytes)
    : call_(rays, bytes) {
  EXPECT_TRUE(call_.is_open());
  if (!call_.is_open()) return;
  const v1::OpenSegmentResponse& response = call_.response();
  taken_ = take_segment(response.socket(), response.key());
  void* const data =
      mmap(nullptr, response.bytes(), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor(), 0);
  EXPECT_NE(data, MAP_FAILED);
  if (data == MAP_FAILED) return;
  data_ = static_cast<std::byte*>(data);
  size_ = response.bytes();
}

SharedSegment::~SharedSegment() {
  if (data_ != nullptr) munmap(data_, size_);
}

std::uint64_t SharedSegment::put(const std::string& column) {
  const std::uint64_t begin = reserve(column.size());
  if (used_ <= size_) std::memcpy(data_ + begin, column.data(), column.size());
  return begin;
}

std::uint64_t SharedSegment::reserve(std::size_t bytes) {
  const std::uint64_t begin = used_;
  used_ += (bytes + 7) / 8 * 8;
  EXPECT_LE(used_, size_) << "the segment is too small for the test";
  return begin;
}

std::string SharedSegment::column(std::uint64_t begin, std::size_t bytes) const {
  return {reinterpret_cast<const char*>(data_) + begin, bytes};
}

}  // namespace sightline::tests
