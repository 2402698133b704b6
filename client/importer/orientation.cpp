// Adds products without rounding: Shewchuk, Adaptive Precision Floating-Point Arithmetic, 1997.
#include "client/importer/orientation.h"

#include <array>
#include <cstddef>

namespace sightline::client::importer {
namespace {

// A sum as parts of increasing size that do not overlap, zeros among them.
class ExactSum {
 public:
  void add(double x) {
    for (std::size_t i = 0; i < count_; ++i) {
      const double sum = x + parts_[i];
      const double of_part = sum - x;
      parts_[i] = (x - (sum - of_part)) + (parts_[i] - of_part);
      x = sum;
    }
    parts_[count_++] = x;
  }

  int sign() const {
    for (std::size_t i = count_; i-- > 0;) {
      if (parts_[i] != 0) return parts_[i] > 0 ? 1 : -1;
    }
    return 0;
  }

 private:
  std::array<double, 6> parts_{};
  std::size_t count_ = 0;
};

}  // namespace

int exact_orientation(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c) {
  ExactSum sum;
  sum.add(a.x * b.y);
  sum.add(-(a.y * b.x));
  sum.add(b.x * c.y);
  sum.add(-(b.y * c.x));
  sum.add(c.x * a.y);
  sum.add(-(c.y * a.x));
  return sum.sign();
}

}  // namespace sightline::client::importer
