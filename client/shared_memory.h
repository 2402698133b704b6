// Memory that a client shares with a server on the same machine, so that rays and answers are not
// copied.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "client/result.h"

namespace sightline::client::calls {
class Segment;
}

namespace sightline::client {

/// How the rays and the answers of large casts go to the server and back.
enum class Transport : std::uint8_t {
  kMessages,  ///< within messages
  kSegments,  ///< through memory that client and server share
};

struct TransportChoice {
  Transport transport = Transport::kMessages;
  std::string reason;  ///< why, for people
};

/// An array in a SharedMemory, whose bytes are released with it. It stays what it is when the
/// memory, or the client, is destroyed. Its values are not set at first.
template <class T>
class SharedArray {
 public:
  SharedArray(SharedArray&&) noexcept = default;
  SharedArray& operator=(SharedArray&&) noexcept = default;

  T* data() const { return values_.get(); }
  std::size_t size() const { return size_; }
  T* begin() const { return data(); }
  T* end() const { return data() + size(); }
  T& operator[](std::size_t i) const { return data()[i]; }
  std::span<T> span() const { return {data(), size()}; }

 private:
  friend class SharedMemory;
  SharedArray(std::shared_ptr<T> values, std::size_t size)
      : values_(std::move(values)), size_(size) {}

  std::shared_ptr<T> values_;
  std::size_t size_;
};

/// Memory for the columns of casts, from Client::share_memory(). Columns that lie in one such
/// memory are not copied, neither here nor on the way; the others of the cast are. While a cast
/// runs, do not write to its rays. After a cast that was cancelled, or whose deadline passed or
/// connection broke, the server may still write to the columns of answers that lie here: the cast
/// fails, the memory is not shared any more, and later casts refuse answers in it. Copies are the
/// same memory. Threads: any, for every member.
class SharedMemory {
 public:
  /// In bytes; at least as many as were asked for.
  std::size_t size() const;
  /// Whether the server has it, as far as is known. Otherwise it is memory like other memory.
  bool is_shared() const;
  /// For people; empty if it is shared.
  std::string why_not_shared() const;

  /// Takes the bytes of `count` values, rounded up to a multiple of 64. Errors: kResourceExhausted,
  /// naming what is asked for, if no free part is as large; kFailedPrecondition (MEMORY_ABANDONED),
  /// the server may still write to the memory.
  template <class T>
    requires std::is_arithmetic_v<T>
  Result<SharedArray<T>> array(std::size_t count) const {
    constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max() / sizeof(T);
    auto bytes = take(count > kMost ? std::numeric_limits<std::size_t>::max() : count * sizeof(T));
    if (!bytes) return bytes.error();
    T* const values = reinterpret_cast<T*>(bytes->get());
    return SharedArray<T>(std::shared_ptr<T>(*std::move(bytes), values), count);
  }

 private:
  friend class Client;
  explicit SharedMemory(std::shared_ptr<calls::Segment> segment);
  Result<std::shared_ptr<std::byte>> take(std::size_t bytes) const;

  std::shared_ptr<calls::Segment> segment_;
};

}  // namespace sightline::client
