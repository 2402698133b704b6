// Imported scenes as bytes, between the process that reads a file and the one that asked for it.
// Both are the same program, so bytes have the layout of its memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace sightline::client::importer {

/// Writes values to a Sink, which has write(const void*, std::size_t). A class that is no sequence
/// needs a function `fields(archive, value)` that passes its members to the archive.
template <class Sink>
class ArchiveWriter {
 public:
  explicit ArchiveWriter(Sink& sink) : sink_(sink) {}

  template <class... Values>
  void operator()(Values&... values) const {
    (put(values), ...);
  }

 private:
  template <class T>
  void put(T& value) const {
    if constexpr (std::is_trivially_copyable_v<T>) {
      sink_.write(&value, sizeof(T));
    } else {
      fields(*this, value);
    }
  }

  template <class T>
  void put_sequence(T& sequence) const {
    const std::uint64_t count = sequence.size();
    sink_.write(&count, sizeof(count));
    if constexpr (std::is_trivially_copyable_v<typename T::value_type>) {
      sink_.write(sequence.data(), count * sizeof(typename T::value_type));
    } else {
      for (auto& element : sequence) put(element);
    }
  }
  template <class T>
  void put(std::vector<T>& sequence) const {
    put_sequence(sequence);
  }
  void put(std::string& text) const { put_sequence(text); }

  Sink& sink_;
};

/// Reads what ArchiveWriter wrote, from bytes that may be anything. After the first value that the
/// bytes do not hold, all others are empty.
class ArchiveReader {
 public:
  explicit ArchiveReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class... Values>
  void operator()(Values&... values) {
    (get(values), ...);
  }

  /// Whether all values were there, and no other bytes.
  bool is_complete() const { return good_ && rest_.empty(); }

 private:
  template <class T>
  void get(T& value) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      take(&value, sizeof(T));
    } else {
      fields(*this, value);
    }
  }

  template <class T>
  void get(std::vector<T>& sequence) {
    get_sequence(sequence);
  }
  void get(std::string& text) { get_sequence(text); }

  template <class T>
  void get_sequence(T& sequence) {
    using Element = typename T::value_type;
    std::uint64_t count = 0;
    take(&count, sizeof(count));
    if constexpr (std::is_trivially_copyable_v<Element>) {
      good_ = good_ && count <= rest_.size() / sizeof(Element);
      if (!good_) return;
      sequence.resize(count);
      take(sequence.data(), count * sizeof(Element));
    } else {
      good_ = good_ && count <= rest_.size();
      for (std::uint64_t i = 0; good_ && i < count; ++i) get(sequence.emplace_back());
    }
  }

  void take(void* value, std::size_t size) {
    good_ = good_ && size <= rest_.size();
    if (!good_ || size == 0) return;
    std::memcpy(value, rest_.data(), size);
    rest_ = rest_.subspan(size);
  }

  std::span<const std::byte> rest_;
  bool good_ = true;
};

}  // namespace sightline::client::importer
