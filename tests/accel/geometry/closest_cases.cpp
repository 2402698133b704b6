// Families of points and faces.
#include "tests/accel/geometry/closest_cases.h"

#include <bit>
#include <cmath>
#include <limits>

namespace sightline::accel::geometry {
namespace {

using tests::Random;
using Matrix = std::array<double, 12>;

constexpr Matrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

int whole(Random& r, int most) {
  return static_cast<int>(r.below(static_cast<std::uint64_t>(2 * most + 1))) - most;
}
Vec3d doubles(Random& r, double size) {
  return {r.uniform(-size, size), r.uniform(-size, size), r.uniform(-size, size)};
}
Vec3f floats(Random& r, double size) { return Vec3f(doubles(r, size)); }
Vec3f wholes(Random& r, int most) {
  return Vec3f{static_cast<float>(whole(r, most)), static_cast<float>(whole(r, most)),
               static_cast<float>(whole(r, most))};
}
double power(Random& r, int least, int most) {
  return std::ldexp(
      r.uniform(1, 2),
      least + static_cast<int>(r.below(static_cast<std::uint64_t>(most - least + 1))));
}

Vec3d transformed(const Matrix& m, const Vec3d& v) {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z + m[3], m[4] * v.x + m[5] * v.y + m[6] * v.z + m[7],
          m[8] * v.x + m[9] * v.y + m[10] * v.z + m[11]};
}

/// Corners are the columns, orthogonal up to rounding, of these lengths; one may be mirrored.
Matrix rotation(Random& r, const Vec3d& lengths, double offset) {
  const Vec3d x = r.direction(), y0 = cross(x, r.direction()), y = y0 * (1 / length(y0)),
              z = cross(x, y);
  const Vec3d t = doubles(r, offset);
  Matrix m;
  for (std::size_t i = 0; i < 3; ++i) {
    m[4 * i] = x[i] * lengths.x;
    m[4 * i + 1] = y[i] * lengths.y;
    m[4 * i + 2] = z[i] * lengths.z;
    m[4 * i + 3] = t[i];
  }
  return m;
}
Matrix any_matrix(Random& r) {
  switch (r.below(5)) {
    case 0:
      return kIdentity;
    case 1:
      return {1, 0, 0, whole(r, 9) * 0.25, 0, 1, 0, r.uniform(-9, 9), 0, 0, 1, 0};
    case 2:
      return rotation(r, {1, 1, 1}, 10);
    case 3:
      return rotation(r, {2, -3, 0.5}, 10);
    default:
      return {0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 2, -4};
  }
}

/// A point on the face, or on an edge or corner of it, moved by up to `off` along each axis.
Vec3d near_face(Random& r, const ClosestCase& c, double off) {
  const Vec3d a(c.vertices[0]), b(c.vertices[1]), d(c.vertices[2]);
  double u = r.uniform(-0.2, 1), v = r.uniform(-0.2, 1);
  if (r.below(3) == 0) u = static_cast<double>(r.below(3)) * 0.5;
  if (r.below(3) == 0) v = 1 - u;
  if (r.below(3) == 0) v = 0;
  return transformed(c.matrix, a + (b - a) * u + (d - a) * v) + doubles(r, off);
}

ClosestCase random_case(Random& r) {
  return {doubles(r, 2), any_matrix(r), {floats(r, 1), floats(r, 1), floats(r, 1)}};
}
ClosestCase near_surface(Random& r) {
  ClosestCase c = random_case(r);
  c.p = near_face(r, c, power(r, -60, -4));
  return c;
}
ClosestCase rounded_to_surface(Random& r) {
  ClosestCase c = random_case(r);
  c.p = near_face(r, c, 0);
  if (r.below(2) == 0) c.p = Vec3d(Vec3f(c.p));
  return c;
}
ClosestCase small_wholes(Random& r) {
  return {Vec3d(wholes(r, 4)),
          r.below(2) == 0 ? kIdentity : Matrix{0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 2, -4},
          {wholes(r, 3), wholes(r, 3), wholes(r, 3)}};
}
/// In multiples of a quarter on the face, an edge or a corner, exactly.
ClosestCase exactly_on(Random& r) {
  ClosestCase c{{}, kIdentity, {wholes(r, 1000), wholes(r, 1000), wholes(r, 1000)}};
  const int u = static_cast<int>(r.below(5)), v = static_cast<int>(r.below(5)) % (5 - u);
  const Vec3d a(c.vertices[0]), b(c.vertices[1]), d(c.vertices[2]);
  c.p = a + (b - a) * (u * 0.25) + (d - a) * (v * 0.25);
  if (r.below(2) == 0) {
    c.matrix = {0, 0.375, 0, 5, -2, 0, 0, 1, 0, 0, 0.5, 7};
    c.p = transformed(c.matrix, c.p);
  }
  return c;
}
/// Multiples of 3 (1, 2, 2), of 7 (2, 3, 6) and of 5 (3, 4, 0): distances are whole, and where they
/// have 54 bits half of an ulp.
ClosestCase whole_distances(Random& r) {
  static const Vec3d kNormals[] = {{1, 2, 2}, {2, 3, 6}, {3, 4, 0}, {0, 0, 1}};
  const Vec3d n = kNormals[r.below(4)];
  const double steps = std::floor(power(r, 0, 50)) * (r.below(2) == 0 ? 1 : 0x1p-20);
  const Vec3d along = n.x == 0 ? Vec3d{1, 0, 0} : Vec3d{n.y, -n.x, 0}, across = cross(n, along);
  const Vec3d first = Vec3d(wholes(r, 3));
  const auto corner = [&](int i, int j) {
    return Vec3f(first + along * (1.0 * i) + across * (1.0 * j));
  };
  ClosestCase c{{}, kIdentity, {corner(-2, -2), corner(3, -1), corner(1, 4)}};
  if (r.below(3) == 0) c.vertices = {Vec3f(first), corner(0, 1), corner(1, 0)};
  if (r.below(3) == 0) c.vertices = {corner(-1, 0), corner(1, 0), corner(0, 0)};
  c.p = first + n * steps;
  return c;
}
/// On an axis: a difference of 54 bits, which is a tie.
ClosestCase halves_of_an_ulp(Random& r) {
  const double x = std::floor(r.uniform(0x1p+52, 0x1p+53));
  const float half = 0.5f * static_cast<float>(1 + 2 * static_cast<int>(r.below(3)));
  const auto corner = [&](float y, float z) { return Vec3f{-half, y, z}; };
  ClosestCase c{{x, 0, 0}, kIdentity, {corner(-1, -1), corner(2, -1), corner(-1, 2)}};
  if (r.below(2) == 0) c.vertices = {corner(0, 0), corner(2, 0), corner(0, 2)};
  if (r.below(3) == 0) c.vertices[2] = c.vertices[1];
  const double scale = std::ldexp(1.0, whole(r, 60));
  c.p = c.p * scale;
  for (Vec3f& v : c.vertices) v = v * static_cast<float>(scale);
  return c;
}
ClosestCase tiny(Random& r) {
  ClosestCase c{{},
                rotation(r, {power(r, -1060, -980), power(r, -1060, -980), 1e-310}, 0),
                {floats(r, 1), floats(r, 1), floats(r, 1)}};
  const double offset = power(r, -1070, -960);
  for (const std::size_t i : {3u, 7u, 11u}) c.matrix[i] = whole(r, 2) * offset;
  return c;
}
ClosestCase far_offset(Random& r) {
  ClosestCase c = random_case(r);
  c.matrix = r.below(2) == 0 ? Matrix{1, 0, 0, 1e7, 0, 1, 0, -2e7, 0, 0, 1, 3e7}
                             : rotation(r, {1e-3, 1e-3, 1e-3}, 1e7);
  c.p = near_face(r, c, power(r, -20, 0));
  return c;
}
ClosestCase offset_floats(Random& r) {
  ClosestCase c{{}, kIdentity, {}};
  const Vec3f to{10000000, -20000000, 30000000};
  for (Vec3f& v : c.vertices) v = to + wholes(r, 50);
  c.p = near_face(r, c, power(r, -20, 3));
  return c;
}
ClosestCase far_away(Random& r) {
  ClosestCase c = random_case(r);
  if (r.below(2) == 0) {
    for (Vec3f& v : c.vertices) v = floats(r, 1e9);
  }
  c.p = r.direction() * power(r, 10, 40);
  return c;
}
ClosestCase needle(Random& r) {
  ClosestCase c = random_case(r);
  const Vec3d a(c.vertices[0]), along = r.direction();
  const double size = power(r, 10, 30);
  c.vertices[1] = Vec3f(a + along * size);
  c.vertices[2] = Vec3f(a + along * (size * r.uniform(-0.5, 1.5)) + doubles(r, size * 1e-8));
  c.p = near_face(r, c, r.below(2) == 0 ? size : power(r, -20, 0));
  return c;
}
ClosestCase without_area(Random& r) {
  ClosestCase c = random_case(r);
  const Vec3f a = wholes(r, 9), step = wholes(r, 9);
  switch (r.below(4)) {
    case 0:
      c.vertices[1] = c.vertices[2];
      break;
    case 1:
      c.vertices[2] = c.vertices[1] = c.vertices[0];
      break;
    default:
      c.vertices = {a, a + step * static_cast<float>(whole(r, 3)),
                    a + step * static_cast<float>(whole(r, 3))};
  }
  if (r.below(2) == 0) c.p = Vec3d(wholes(r, 20));
  if (r.below(4) == 0) c.p = near_face(r, c, power(r, -40, 0));
  return c;
}
ClosestCase sheared(Random& r) {
  ClosestCase c = random_case(r);
  c.matrix = rotation(r, {1e3, -1e-3, power(r, -10, 10)}, 5);
  for (std::size_t i = 0; i < 3; ++i) c.matrix[4 * i] += 1e6 * c.matrix[4 * i + 1];
  c.p = near_face(r, c, power(r, -10, 4));
  return c;
}
ClosestCase ill_conditioned(Random& r) {
  ClosestCase c = random_case(r);
  c.matrix = rotation(r, {1e6, 1, 1e-6}, power(r, -10, 20));
  c.p = near_face(r, c, power(r, -40, 20));
  return c;
}
ClosestCase denormal(Random& r) {
  ClosestCase c{{}, any_matrix(r), {floats(r, 1e-40), floats(r, 1e-40), floats(r, 1e-40)}};
  if (r.below(2) == 0) c.matrix[3] = c.matrix[7] = c.matrix[11] = 0;
  c.p = near_face(r, c, r.below(2) == 0 ? 1e-40 : 1);
  if (r.below(3) == 0) c.p = doubles(r, 1e-76);
  return c;
}
ClosestCase wide_faces(Random& r) {
  ClosestCase c = random_case(r);
  for (Vec3f& v : c.vertices) v = floats(r, 1e5);
  c.p = near_face(r, c, power(r, -10, 3));
  return c;
}
/// Every bit pattern that is allowed.
ClosestCase any_bits(Random& r) {
  ClosestCase c;
  const bool extreme = r.below(2) == 0;
  const auto number = [&](double most) {
    for (;;) {
      const double x =
          extreme ? std::bit_cast<double>(r.next()) : std::ldexp(r.uniform(-1, 1), whole(r, 200));
      if (r.below(5) == 0) return 0.0;
      if (std::fabs(x) <= most) return x;
    }
  };
  for (double& x : c.matrix) x = number(std::numeric_limits<double>::max());
  c.p = {number(0x1p+250), number(0x1p+250), number(0x1p+250)};
  for (Vec3f& v : c.vertices) {
    for (std::size_t i = 0; i < 3; ++i) v[i] = static_cast<float>(number(3e38));
  }
  return c;
}

}  // namespace

const std::vector<ClosestFamily>& closest_families() {
  static const std::vector<ClosestFamily> families = {
      {"random", random_case},
      {"near_surface", near_surface},
      {"rounded_to_surface", rounded_to_surface},
      {"small_wholes", small_wholes},
      {"exactly_on", exactly_on},
      {"whole_distances", whole_distances},
      {"halves_of_an_ulp", halves_of_an_ulp},
      {"tiny", tiny},
      {"far_offset", far_offset},
      {"offset_floats", offset_floats},
      {"far_away", far_away},
      {"needle", needle},
      {"without_area", without_area},
      {"sheared", sheared},
      {"ill_conditioned", ill_conditioned},
      {"denormal", denormal},
      {"wide_faces", wide_faces},
      {"any_bits", any_bits},
  };
  return families;
}

}  // namespace sightline::accel::geometry
