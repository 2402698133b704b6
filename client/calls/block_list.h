// Which bytes of a segment are free. Internal to the library.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

namespace sightline::client::calls {

/// Blocks of [0, bytes), each beginning at a multiple of kAlignment. Threads: one at a time.
class BlockList {
 public:
  /// What vectors of the processor like, and more than any element of a column needs.
  static constexpr std::uint64_t kAlignment = 64;

  explicit BlockList(std::uint64_t bytes);

  /// The lowest free block of this size, so that memory which was used last is used again. Nothing:
  /// there is none.
  std::optional<std::uint64_t> take(std::uint64_t bytes);
  /// Frees a block that was taken with this size.
  void release(std::uint64_t offset, std::uint64_t bytes);

 private:
  std::map<std::uint64_t, std::uint64_t> free_;  ///< Sizes by offset; neighbours are merged.
};

}  // namespace sightline::client::calls
