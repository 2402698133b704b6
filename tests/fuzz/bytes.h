// A fuzzer's input, read from the front.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace sightline::tests {

class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }
  std::span<const std::uint8_t> rest() const { return bytes_; }

  /// Missing bytes are zero.
  template <class T>
  T take() {
    T value{};
    const std::size_t size = std::min(sizeof(T), bytes_.size());
    if (size == 0) return value;
    std::memcpy(&value, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
    return value;
  }
  /// One byte, as a number below `n`; n > 0.
  std::size_t below(std::size_t n) { return take<std::uint8_t>() % n; }
  /// Finite: the exponents of infinity and NaN lose their first bit.
  template <class T>
  T take_number() {
    const T x = take<T>();
    if (std::isfinite(x)) return x;
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    return std::bit_cast<T>(std::bit_cast<Bits>(x) & ~(Bits{1} << (sizeof(T) * 8 - 2)));
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace sightline::tests
