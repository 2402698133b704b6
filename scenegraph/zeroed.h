// An array of zeros that costs memory only where it has been written.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace sightline::scenegraph {

/// `size` objects of a type for which all bits zero is a value. Throws std::bad_alloc.
template <class T>
class Zeroed {
 public:
  explicit Zeroed(std::size_t size)
      : data_(static_cast<T*>(std::calloc(size > 0 ? size : 1, sizeof(T)))), size_(size) {
    static_assert(std::is_trivially_destructible_v<T>);
    if (data_ == nullptr) throw std::bad_alloc();
  }

  T& operator[](std::size_t i) const { return data_.get()[i]; }
  std::size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(T* p) const { std::free(p); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_;
};

}  // namespace sightline::scenegraph
