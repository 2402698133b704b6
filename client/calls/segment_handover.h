// How a client gets the memory of a segment. Internal to the library.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "client/calls/descriptor.h"
#include "client/calls/server_process.h"
#include "client/result.h"

namespace sightline::client::calls {

/// Memory of this process. Unmapped when it is destroyed.
class Mapping {
 public:
  /// Memory that only this process has. Errors: kResourceExhausted.
  static Result<Mapping> anonymous(std::uint64_t bytes);
  /// What an open file holds. Errors: kUnavailable, it holds less, or another process could cut it
  /// short, so that an access would end this one; kResourceExhausted.
  static Result<Mapping> of_segment(int descriptor, std::uint64_t bytes);

  std::byte* data() const { return data_.get(); }
  std::uint64_t size() const { return data_.get_deleter().bytes; }

 private:
  struct Unmap {
    std::uint64_t bytes;
    void operator()(std::byte* data) const;
  };

  static Result<Mapping> map(int descriptor, std::uint64_t bytes, int flags);

  std::unique_ptr<std::byte[], Unmap> data_;
};

struct ReceivedSegment {
  /// Open as long as the memory is mapped: where it is closed, and the call of the segment has
  /// ended, the server takes the pages back, which then read as zeros.
  Descriptor connection;
  Mapping memory;
  ServerProcess server;
};

/// Connects to the Unix socket of this abstract name, sends the key, and maps the segment that is
/// sent back. Errors: kUnavailable, no process of this network namespace listens there, it sends no
/// segment by the deadline, or one that of_segment() refuses; kInternal, the server has sent a name
/// or a key of another form.
Result<ReceivedSegment> receive_segment(const std::string& socket, const std::string& key,
                                        std::uint64_t bytes,
                                        std::chrono::system_clock::time_point deadline);

}  // namespace sightline::client::calls
