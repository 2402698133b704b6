// Corners minus the point: differences of doubles where the matrix is the identity, sums with their
// rounding errors otherwise.
#include "accel/geometry/seen_face.h"

#include <algorithm>
#include <cmath>

#include "accel/geometry/closest_feature.h"

namespace sightline::accel::geometry {
namespace {

using Matrix = std::array<double, 12>;

constexpr Matrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// Sizes of all coordinates of corners, edges and matrices, other than 0, between which products
/// neither overflow nor underflow.
constexpr double kLargestSize = 0x1p+160;
constexpr double kLargestFactor = 0x1p+300;

class SizeRange {
 public:
  void add(double x) {
    const double size = std::fabs(x);
    most_ = std::max(most_, size);
    least_ = std::min(least_, size == 0 ? 1.0 : size);
  }
  void add(const Vec3d& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  bool within(double largest) const { return most_ <= largest && least_ >= 1 / largest; }

 private:
  double most_ = 1, least_ = 1;
};

/// A sum of at most five doubles and three products: the roundings of the sum are added up beside
/// it, and the roundings of that sum in turn, so that it may cancel.
class CompensatedSum {
 public:
  void add(double x) {
    const DoubleDouble sum = two_sum(high_, x);
    high_ = sum.high;
    add_low(sum.low);
  }
  /// Adds a factor, of which the halves are given, times a float.
  void add_product(double factor, const DoubleDouble& halves, double x) {
    const double product = factor * x;
    add_low((halves.high * x - product) + halves.low * x);
    add(product);
  }

  struct Total {
    DoubleDouble value;
    double error = 0;
  };
  Total total() const {
    const DoubleDouble sum = two_sum(high_, low_), low = two_sum(sum.low, rest_);
    // The rest had seven additions, each off by at most 2^-53 of what they have added up.
    return {two_sum(sum.high, low.high), 2 * std::fabs(low.low) + 0x1p-50 * rest_size_};
  }

 private:
  void add_low(double x) {
    const DoubleDouble sum = two_sum(low_, x);
    low_ = sum.high;
    rest_ += sum.low;
    rest_size_ += std::fabs(sum.low);
  }

  double high_ = 0, low_ = 0, rest_ = 0, rest_size_ = 0;
};

/// M v as sums.
class Transform {
 public:
  explicit Transform(const Matrix& matrix) : matrix_(matrix) {
    for (std::size_t i = 0; i < 12; ++i) halves_[i] = halves(matrix[i]);
  }
  CompensatedSum transformed(const Vec3f& v, std::size_t axis) const {
    CompensatedSum sum;
    for (std::size_t j = 0; j < 3; ++j) {
      sum.add_product(matrix_[4 * axis + j], halves_[4 * axis + j], static_cast<double>(v[j]));
    }
    sum.add(matrix_[4 * axis + 3]);
    return sum;
  }

 private:
  const Matrix& matrix_;
  std::array<DoubleDouble, 12> halves_;
};

bool in_range(const Matrix& matrix) {
  SizeRange range;
  for (const double x : matrix) range.add(x);
  return range.within(kLargestFactor);
}

bool in_range(const SeenFace& face) {
  SizeRange range;
  for (const Vec3dd& v : face.corner) range.add(high(v));
  for (const Vec3dd& v : face.edge) range.add(high(v));
  return range.within(kLargestSize);
}

Vec3dd exact_difference(const Vec3d& a, const Vec3d& b) {
  return {two_sum(a.x, -b.x), two_sum(a.y, -b.y), two_sum(a.z, -b.z)};
}

void see_plain(const Vec3d& p, const std::array<Vec3f, 3>& vertices, SeenFace& face) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d v(vertices[i]);
    face.corner[i] = exact_difference(v, p);
    face.edge[i] = exact_difference(Vec3d(vertices[corner_after(i)]), v);
  }
}

void see_transformed(const Vec3d& p, const Matrix& matrix, const std::array<Vec3f, 3>& vertices,
                     SeenFace& face) {
  const Transform transform(matrix);
  for (std::size_t i = 0; i < 3; ++i) {
    double error = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CompensatedSum sum = transform.transformed(vertices[i], axis);
      sum.add(-p[axis]);
      const CompensatedSum::Total total = sum.total();
      face.corner[i][axis] = total.value;
      error += total.error;
    }
    face.error = std::max(face.error, error);
  }
  for (std::size_t i = 0; i < 3; ++i) face.edge[i] = face.corner[corner_after(i)] - face.corner[i];
}

}  // namespace

bool see(const Vec3d& p, const Matrix& matrix, const std::array<Vec3f, 3>& vertices,
         SeenFace& face) {
  if (matrix == kIdentity) {
    see_plain(p, vertices, face);
  } else {
    if (!in_range(matrix)) return false;
    see_transformed(p, matrix, vertices, face);
  }
  return in_range(face);
}

std::optional<Vec3d> rounded_corner(const Matrix& matrix, const Vec3f& v) {
  if (matrix == kIdentity) return Vec3d(v) + Vec3d{};  // No negative zero
  const Transform transform(matrix);
  Vec3d result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [x, error] = transform.transformed(v, axis).total();
    // Where x is half way between two doubles, an error below the last bit of `low` counts, too.
    const double around = error == 0 ? 0 : error + 0x1p-50 * std::fabs(x.low);
    if (x.high + (x.low - around) != x.high || x.high + (x.low + around) != x.high)
      return std::nullopt;
    result[axis] = x.high;
  }
  return result;
}

}  // namespace sightline::accel::geometry
