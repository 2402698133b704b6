// A file descriptor that is closed with its owner. Internal to the library.
#pragma once

#include <unistd.h>

#include <utility>

namespace sightline::client::calls {

class Descriptor {
 public:
  /// Below 0: none.
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }

  int number() const { return number_; }
  explicit operator bool() const { return number_ >= 0; }

 private:
  int number_;
};

}  // namespace sightline::client::calls
