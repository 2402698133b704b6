// Products, inverses and compositions of affine maps.
#include "client/importer/affine.h"

#include <cstddef>

namespace sightline::client::importer {

Transform operator*(const Transform& a, const Transform& b) {
  Transform out{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 4; ++c) {
      double sum = c == 3 ? a[4 * r + 3] : 0;
      for (std::size_t k = 0; k < 3; ++k) sum += a[4 * r + k] * b[4 * k + c];
      out[4 * r + c] = sum;
    }
  }
  return out;
}

Point operator*(const Transform& m, const Point& p) {
  Point out{};
  for (std::size_t r = 0; r < 3; ++r) {
    out[r] = m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] + m[4 * r + 3];
  }
  return out;
}

Transform inverse(const Transform& m) {
  const auto at = [&](std::size_t r, std::size_t c) { return m[4 * (r % 3) + c % 3]; };
  Transform out{};
  double determinant = 0;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double cofactor =
          at(r + 1, c + 1) * at(r + 2, c + 2) - at(r + 1, c + 2) * at(r + 2, c + 1);
      out[4 * c + r] = cofactor;
      if (r == 0) determinant += m[c] * cofactor;
    }
  }
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) out[4 * r + c] /= determinant;
    out[4 * r + 3] = -(out[4 * r] * m[3] + out[4 * r + 1] * m[7] + out[4 * r + 2] * m[11]);
  }
  return out;
}

Transform compose(const Point& position, const Quaternion& q, const Point& s) {
  const auto [w, x, y, z] = q;
  const std::array<Point, 3> rotation{
      {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
       {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
       {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
  Transform out{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) out[4 * r + c] = rotation[r][c] * s[c];
    out[4 * r + 3] = position[r];
  }
  return out;
}

}  // namespace sightline::client::importer
