// Memory that a client on this machine shares with the server.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "proto/result.h"
#include "server/net/descriptor.h"
#include "server/segments/segment_account.h"

namespace sightline::server::segments {

/// A memfd that the server has made and mapped. It can be neither shrunk nor grown, so that no
/// access fails, whatever a client does with the descriptor. A client may write any byte at any
/// time: what is read is copied first, and what is written is not read back.
///
/// The pages go back to the system when the segment ends and its client is gone, even if a process
/// still has them mapped. Where the server ends before its client, they stay what they are as long
/// as they are mapped: they are the arrays of an honest client.
///
/// Threads: any, for every member.
class Segment {
 public:
  /// Makes one of `bytes` zeros, whole pages, all of which the system has given. May take a
  /// millisecond for each 4 MiB. `principal`: whose it is. Errors: kResourceExhausted.
  static Result<std::shared_ptr<const Segment>> make(std::uint64_t bytes, std::string principal,
                                                     SegmentAccount::Held held);
  /// May take a millisecond for each 16 MiB, as the pages go back.
  ~Segment();
  Segment(const Segment&) = delete;
  Segment& operator=(const Segment&) = delete;

  /// Whether the system keeps what make() promises: with strict accounting of memory
  /// (vm.overcommit_memory = 2), a page that a client has given back may not be had again, and who
  /// touches it is ended by SIGBUS.
  static bool is_safe();

  std::uint64_t size() const { return size_; }
  const std::string& principal() const { return principal_; }
  /// What clients get. It stays open as long as the segment lives.
  int descriptor() const { return descriptor_.number(); }

  /// Its client has closed the connection by which it has the descriptor: it has no use for the
  /// memory any more.
  void note_client_gone() const { is_client_gone_ = true; }

  /// Copies bytes, which the segment has.
  void read(std::uint64_t offset, void* to, std::size_t bytes) const;
  void write(std::uint64_t offset, const void* from, std::size_t bytes) const;

 private:
  Segment(net::Descriptor descriptor, std::byte* data, std::uint64_t size, std::string principal,
          SegmentAccount::Held held);

  const SegmentAccount::Held held_;  // given back last
  const net::Descriptor descriptor_;
  std::byte* const data_;
  const std::uint64_t size_;
  const std::string principal_;
  mutable std::atomic<bool> is_client_gone_ = false;
};

/// Bytes of a page; sizes of segments are multiples of it.
std::uint64_t page_size();

}  // namespace sightline::server::segments
