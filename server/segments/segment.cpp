// Memory that a client on this machine shares with the server.
#include "server/segments/segment.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

namespace sightline::server::segments {
namespace {

Error out_of_memory(const char* call, std::uint64_t bytes) {
  return {Code::kResourceExhausted,
          fmt::format("the system gives no segment of {} bytes: {}: {}", bytes, call,
                      std::generic_category().message(errno)),
          "NO_SEGMENT_MEMORY"};
}

/// Gives the file all its pages, or, by its mode, takes them. Returns 0, or -1 and errno.
int change_pages(int descriptor, int mode, std::uint64_t bytes) {
  int failed = 0;
  do {
    failed = fallocate(descriptor, mode, 0, static_cast<off_t>(bytes));
  } while (failed != 0 && errno == EINTR);
  return failed;
}

}  // namespace

std::uint64_t page_size() {
  static const auto kBytes = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return kBytes;
}

Result<std::shared_ptr<const Segment>> Segment::make(std::uint64_t bytes, std::string principal,
                                                     SegmentAccount::Held held) {
  assert(bytes > 0 && bytes % page_size() == 0);
  net::Descriptor made(memfd_create("sightline-segment", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!made) return out_of_memory("memfd_create", bytes);
  if (ftruncate(made.number(), static_cast<off_t>(bytes)) != 0)
    return out_of_memory("ftruncate", bytes);
  // Want of memory is an error here, and not a signal later.
  if (change_pages(made.number(), 0, bytes) != 0) return out_of_memory("fallocate", bytes);
  if (fcntl(made.number(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    return out_of_memory("F_ADD_SEALS", bytes);
  void* const data =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, made.number(), 0);
  if (data == MAP_FAILED) return out_of_memory("mmap", bytes);
  return std::shared_ptr<const Segment>(new Segment(std::move(made), static_cast<std::byte*>(data),
                                                    bytes, std::move(principal), std::move(held)));
}

Segment::Segment(net::Descriptor descriptor, std::byte* data, std::uint64_t size,
                 std::string principal, SegmentAccount::Held held)
    : held_(std::move(held)),
      descriptor_(std::move(descriptor)),
      data_(data),
      size_(size),
      principal_(std::move(principal)) {}

Segment::~Segment() {
  munmap(data_, size_);
  constexpr int kTake = FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE;
  if (is_client_gone_ && change_pages(descriptor_.number(), kTake, size_) != 0) {
    spdlog::warn("event=segment_not_given_back bytes={} reason=\"{}\"", size_,
                 std::generic_category().message(errno));
  }
}

bool Segment::is_safe() {
  int overcommit = 0;
  std::ifstream("/proc/sys/vm/overcommit_memory") >> overcommit;
  return overcommit != 2;
}

void Segment::read(std::uint64_t offset, void* to, std::size_t bytes) const {
  assert(offset <= size_ && bytes <= size_ - offset);
  if (bytes > 0) std::memcpy(to, data_ + offset, bytes);
}

void Segment::write(std::uint64_t offset, const void* from, std::size_t bytes) const {
  assert(offset <= size_ && bytes <= size_ - offset);
  if (bytes > 0) std::memcpy(data_ + offset, from, bytes);
}

}  // namespace sightline::server::segments
