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
  // Axes have their own bounds, so that they do not wait for each other.
  void add(const Vec3d& v) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double size = std::fabs(v[axis]);
      most_[axis] = std::max(most_[axis], size);
      least_[axis] = std::min(least_[axis], size == 0 ? 1.0 : size);
    }
  }
  bool within(double largest) const {
    return std::max({most_.x, most_.y, most_.z}) <= largest &&
           std::min({least_.x, least_.y, least_.z}) >= 1 / largest;
  }

 private:
  Vec3d most_{1, 1, 1}, least_{1, 1, 1};
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

Vec3dd exact_difference(const Vec3d& a, const Vec3d& b) {
  return {two_sum(a.x, -b.x), two_sum(a.y, -b.y), two_sum(a.z, -b.z)};
}

void see_corner(const Vec3d& p, const std::array<Vec3f, 3>& vertices, std::size_t i,
                SeenFace& face) {
  face.corner[i] = exact_difference(Vec3d(vertices[i]), p);
}

void see_edge(const std::array<Vec3f, 3>& vertices, std::size_t i, SeenFace& face) {
  face.edge[i] = exact_difference(Vec3d(vertices[corner_after(i)]), Vec3d(vertices[i]));
}

void see_corner(const Vec3d& p, const Transform& transform, const std::array<Vec3f, 3>& vertices,
                std::size_t i, SeenFace& face) {
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

}  // namespace

bool is_identity(const Matrix& matrix) { return matrix == kIdentity; }

bool is_in_range(const Matrix& matrix) {
  SizeRange range;
  for (std::size_t i = 0; i < 12; i += 3) range.add({matrix[i], matrix[i + 1], matrix[i + 2]});
  return range.within(kLargestFactor);
}

bool is_in_range(const SeenFace& face) {
  SizeRange range;
  for (const Vec3dd& v : face.corner) range.add(high(v));
  for (const Vec3dd& v : face.edge) range.add(high(v));
  return range.within(kLargestSize);
}

bool are_in_range(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  SizeRange range;
  range.add(a);
  range.add(b);
  range.add(c);
  return range.within(kLargestSize);
}

double see_leading(const Vec3d& p, const Matrix& matrix, bool plain,
                   const std::array<Vec3f, 3>& vertices, SeenFace& face) {
  const auto leading = [](const Vec3d& v) { return Vec3dd{{v.x}, {v.y}, {v.z}}; };
  if (plain) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d v(vertices[i]);
      face.corner[i] = leading(v - p);
      face.edge[i] = leading(Vec3d(vertices[corner_after(i)]) - v);
    }
    return 0;
  }
  Vec3d largest;
  std::array<Vec3d, 3> corner;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* const row = &matrix[4 * axis];
    const double origin = row[3] - p[axis], size = std::fabs(row[3]) + std::fabs(p[axis]);
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = row[0] * static_cast<double>(vertices[i].x),
                   y = row[1] * static_cast<double>(vertices[i].y),
                   z = row[2] * static_cast<double>(vertices[i].z);
      corner[i][axis] = ((x + y) + z) + origin;
      largest[axis] =
          std::max(largest[axis], ((std::fabs(x) + std::fabs(y)) + std::fabs(z)) + size);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    face.corner[i] = leading(corner[i]);
    face.edge[i] = leading(corner[corner_after(i)] - corner[i]);
  }
  return 8 * std::max({largest.x, largest.y, largest.z});  // five roundings
}

bool see_part(const Vec3d& p, const Matrix& matrix, const std::array<Vec3f, 3>& vertices,
              const Feature& part, SeenFace& face) {
  if (is_identity(matrix)) {
    const std::size_t i = part.index;
    see_corner(p, vertices, i, face);
    if (part.part != Part::kCorner) see_edge(vertices, i, face);
    if (part.part == Part::kInside) see_edge(vertices, 2, face);
    return true;  // the leading doubles are in range
  }
  const Transform transform(matrix);
  const std::size_t count = part.part == Part::kCorner ? 1 : part.part == Part::kEdge ? 2 : 3;
  std::size_t i = part.index;
  for (std::size_t k = 0; k < count; ++k, i = corner_after(i))
    see_corner(p, transform, vertices, i, face);
  if (count > 1)
    face.edge[part.index] = face.corner[corner_after(part.index)] - face.corner[part.index];
  if (count > 2) face.edge[2] = face.corner[0] - face.corner[2];
  return is_in_range(face);
}

bool see(const Vec3d& p, const Matrix& matrix, const std::array<Vec3f, 3>& vertices,
         SeenFace& face) {
  if (is_identity(matrix)) {
    for (std::size_t i = 0; i < 3; ++i) {
      see_corner(p, vertices, i, face);
      see_edge(vertices, i, face);
    }
  } else {
    if (!is_in_range(matrix)) return false;
    const Transform transform(matrix);
    for (std::size_t i = 0; i < 3; ++i) see_corner(p, transform, vertices, i, face);
    for (std::size_t i = 0; i < 3; ++i)
      face.edge[i] = face.corner[corner_after(i)] - face.corner[i];
  }
  return is_in_range(face);
}

std::optional<Vec3d> rounded_corner(const Matrix& matrix, const Vec3f& v) {
  if (is_identity(matrix)) return Vec3d(v) + Vec3d{};  // No negative zero
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
