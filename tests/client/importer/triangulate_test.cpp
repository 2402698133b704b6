// Triangles cover their polygon once: they all turn as it does, and there are n - 2 of them.
#include "client/importer/triangulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "client/importer/orientation.h"
#include "tests/support/random.h"
#include "tests/support/rounds.h"

namespace sightline::client::importer {
namespace {

using tests::Random;
using Flat = std::array<double, 2>;
using Outline = std::vector<Flat>;

/// Where the outline's axes go.
struct Plane {
  std::array<double, 3> origin{}, u{1, 0, 0}, v{0, 1, 0};
};

std::vector<Vertex> placed(const Outline& outline, const Plane& plane) {
  std::vector<Vertex> out;
  for (const auto& [x, y] : outline) {
    Vertex& vertex = out.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
      vertex[k] = static_cast<float>(plane.origin[k] + x * plane.u[k] + y * plane.v[k]);
  }
  return out;
}

struct Cut {
  std::vector<Face> faces;
  bool is_simple = false;
};

Cut cut(const std::vector<Vertex>& vertices) {
  std::vector<std::uint32_t> corners(vertices.size());
  for (std::uint32_t i = 0; i < corners.size(); ++i) corners[i] = i;
  Cut out;
  out.is_simple = Triangulator(vertices).cut(corners, out.faces);
  return out;
}

/// Twice the area of the polygon in the plane that leaves out an axis.
double area(const std::vector<Vertex>& vertices, std::size_t axis) {
  const auto at = [&](std::size_t i, std::size_t k) {
    return static_cast<double>(vertices[i % vertices.size()][(axis + k) % 3]) -
           static_cast<double>(vertices[0][(axis + k) % 3]);
  };
  double sum = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    sum += at(i, 1) * at(i + 1, 2) - at(i, 2) * at(i + 1, 1);
  return sum;
}

/// Covered once, if the polygon does not intersect itself: by the argument in triangulate.cpp.
void expect_covered(const std::vector<Vertex>& vertices, const std::string& what) {
  const Cut result = cut(vertices);
  EXPECT_TRUE(result.is_simple) << what;
  ASSERT_EQ(result.faces.size(), vertices.size() - 2) << what;
  std::size_t axis = 0;
  for (const std::size_t k : {1U, 2U}) {
    if (std::abs(area(vertices, k)) > std::abs(area(vertices, axis))) axis = k;
  }
  const int turn = area(vertices, axis) > 0 ? 1 : -1;
  const auto point = [&](std::uint32_t i) {
    return PlanePoint{static_cast<double>(vertices[i][(axis + 1) % 3]),
                      static_cast<double>(vertices[i][(axis + 2) % 3])};
  };
  for (const auto& [a, b, c] : result.faces)
    ASSERT_GE(exact_orientation(point(a), point(b), point(c)) * turn, 0) << what;
}

Plane random_plane(Random& random, double scale) {
  const auto a = random.direction(), b = random.direction();
  auto v = accel::geometry::cross(a, b);
  v = v * (1 / std::sqrt(dot(v, v)));
  const auto from = random.direction() * scale;
  return {{from.x, from.y, from.z},
          {scale * a.x, scale * a.y, scale * a.z},
          {scale * v.x, scale * v.y, scale * v.z}};
}

Outline star(std::size_t n, Random& random) {
  Outline out;
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (static_cast<double>(i) + random.uniform(0, 0.9)) /
                         static_cast<double>(n);
    const double radius = random.uniform(0.1, 1);
    out.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return out;
}

/// Teeth on a bar, their feet on one line.
Outline comb(std::size_t teeth) {
  Outline out{{0, 0}, {2.0 * static_cast<double>(teeth), 0}};
  for (std::size_t i = teeth; i-- > 0;) {
    const double x = 2.0 * static_cast<double>(i);
    out.insert(out.end(), {{x + 2, 1}, {x + 1.5, 5}, {x + 1, 1}});
  }
  out.push_back({0, 1});
  return out;
}

Outline skyline(std::size_t houses, Random& random) {
  Outline out{{0, 0}, {static_cast<double>(houses), 0}};
  for (std::size_t i = houses; i-- > 0;) {
    const auto height = static_cast<double>(1 + random.below(4)), x = static_cast<double>(i);
    out.insert(out.end(), {{x + 1, height}, {x, height}});
  }
  return out;
}

Outline spiral(std::size_t n, double step) {
  Outline out;
  for (const bool is_inner : {false, true}) {
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = step * static_cast<double>(is_inner ? n - 1 - i : i);
      const double radius = angle + (is_inner ? 1 : 3);
      out.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
  }
  return out;
}

/// More corners on the edges, some of them twice.
Outline subdivided(const Outline& outline, Random& random) {
  Outline out;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Flat &a = outline[i], &b = outline[(i + 1) % outline.size()];
    out.push_back(a);
    for (std::size_t k = random.below(4); k > 0; --k) {
      const double t = 1 / static_cast<double>(k + 1);
      const Flat last = out.back();
      out.push_back({last[0] + t * (b[0] - last[0]), last[1] + t * (b[1] - last[1])});
    }
    if (random.below(8) == 0) out.push_back(out.back());
  }
  return out;
}

TEST(Triangulate, RandomPolygonsOfAnySizeInAnyPlane) {
  Random random(1);
  for (int round = 0; round < 300; ++round) {
    const double scale = std::pow(10, random.uniform(-6, 6));
    const std::vector<std::pair<std::string, Outline>> outlines{
        {"star", star(5 + random.below(40), random)},
        {"comb", comb(1 + random.below(20))},
        {"skyline", skyline(1 + random.below(20), random)},
        {"spiral", spiral(20 + random.below(60), 0.2)}};
    for (const auto& [name, outline] : outlines) {
      expect_covered(placed(outline, random_plane(random, scale)), name);
      expect_covered(placed(subdivided(outline, random), {{}, {scale, 0, 0}, {0, 0, scale}}),
                     name + ", on lines");
      expect_covered(placed(subdivided(outline, random), random_plane(random, scale)),
                     name + ", nearly on lines");
    }
  }
}

TEST(Triangulate, AWallWithASlotInEachDirection) {
  const Outline wall{{10, -10}, {10, -5}, {10, 0}, {5, 0},   {0, 0},  {0, -4},
                     {5, -4},   {5, -6},  {0, -6}, {0, -10}, {5, -10}};
  for (std::size_t first = 0; first < wall.size(); ++first) {
    for (const bool is_reversed : {false, true}) {
      Outline outline = wall;
      std::rotate(outline.begin(), outline.begin() + static_cast<std::ptrdiff_t>(first),
                  outline.end());
      if (is_reversed) std::reverse(outline.begin(), outline.end());
      expect_covered(placed(outline, {}), std::to_string(first));
    }
  }
}

TEST(Triangulate, ConvexPolygonsAreFans) {
  EXPECT_EQ(cut(placed({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {})).faces,
            (std::vector<Face>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(cut(placed({{0, 0}, {2, 0}, {3, 1}, {2, 2}, {0, 2}}, {})).faces,
            (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(Triangulate, AFanAvoidsTrianglesWithoutArea) {
  EXPECT_EQ(cut(placed({{0, 0}, {1, 0}, {2, 0}, {0, 2}}, {})).faces,
            (std::vector<Face>{{1, 2, 3}, {1, 3, 0}}));
}

TEST(Triangulate, AConcaveQuadrangleIsCutAtItsConcaveCorner) {
  for (std::uint32_t first = 0; first < 4; ++first) {
    Outline arrow{{0, 0}, {2, 1}, {0, 2}, {0.5, 1}};
    std::rotate(arrow.begin(), arrow.begin() + first, arrow.end());
    const std::uint32_t concave = (3 + 4 - first) % 4;
    const Cut result = cut(placed(arrow, {}));
    EXPECT_EQ(result.faces[0][0], concave);
    EXPECT_EQ(result.faces[1][0], concave);
    expect_covered(placed(arrow, {}), "arrow");
  }
}

TEST(Triangulate, BridgesToHolesAndTouchingBoundaries) {
  const Outline hole{{0, 0}, {1, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1},
                     {1, 1}, {1, 0}, {4, 0}, {4, 3}, {0, 3}};
  const Outline spike{{0, 0}, {4, 0}, {4, 3}, {2, 3}, {2, 1}, {2, 3}, {0, 3}};
  const Outline outer_spike{{0, 0}, {4, 0}, {6, 0}, {4, 0}, {4, 3}, {0, 3}};
  const Outline pinched{{0, 0}, {2, 2}, {4, 0}, {4, 4}, {2, 2}, {0, 4}};
  const Outline touched{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}};
  Random random(2);
  for (const Outline& outline : {hole, spike, outer_spike, pinched, touched}) {
    for (std::size_t first = 0; first < outline.size(); ++first) {
      Outline turned = outline;
      std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(first),
                  turned.end());
      expect_covered(placed(turned, {}), std::to_string(outline.size()));
      std::reverse(turned.begin(), turned.end());
      expect_covered(placed(turned, {{5, 6, 7}, {0, 0, 1e-6}, {0, 1e-6, 0}}), "reversed");
    }
  }
}

// Bridges have other corners on the way there than on the way back: rounded, the two may cross.
TEST(Triangulate, CrossingsByRoundingAreNone) {
  Random random(7);
  const Outline bridged{{0, 0}, {1, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1},
                        {1, 1}, {1, 0}, {4, 0}, {4, 3}, {0, 3}};
  for (int round = 0; round < 300; ++round) {
    const auto vertices = placed(subdivided(bridged, random), random_plane(random, 1));
    const Cut result = cut(vertices);
    EXPECT_TRUE(result.is_simple) << round;
    EXPECT_EQ(result.faces.size(), vertices.size() - 2);
  }
}

TEST(Triangulate, WithoutAreaNothingIsCovered) {
  for (const Outline& outline :
       {Outline{{0, 0}, {1, 1}, {2, 2}, {3, 3}, {1, 1}}, Outline{{1, 1}, {1, 1}, {1, 1}, {1, 1}}}) {
    const Cut result = cut(placed(outline, {}));
    EXPECT_TRUE(result.is_simple);
    EXPECT_EQ(result.faces.size(), outline.size() - 2);
  }
}

TEST(Triangulate, ThereAndBackCoversNothing) {
  Random random(5);
  for (const Outline& outline :
       {Outline{{0, 0}, {1, 0}, {1, 1}, {1, 0}}, Outline{{0, 0}, {2, 1}, {0, 3}, {2, 1}},
        Outline{{0, 0}, {1, 0}, {1, 1}, {0, 2}, {1, 1}, {1, 0}}}) {
    for (const Plane& plane : {Plane{}, Plane{{}, {1, 0, 0}, {0, 0, 1}},
                               Plane{{}, {0, 1, 0}, {0, 0, 1}}, random_plane(random, 1)}) {
      const std::vector<Vertex> vertices = placed(outline, plane);
      const Cut result = cut(vertices);
      EXPECT_EQ(result.faces.size(), outline.size() - 2);
      for (const auto& [a, b, c] : result.faces)
        EXPECT_TRUE(vertices[a] == vertices[b] || vertices[b] == vertices[c] ||
                    vertices[c] == vertices[a]);
    }
  }
}

TEST(Triangulate, CrossingsAreSaid) {
  const Outline bow_tie{{0, 0}, {1, 1}, {1, 0}, {0, 1}};
  const Outline eight{{0, 0}, {2, 0}, {2, 2}, {3, 2}, {3, -1}, {1, -1}, {1, 1}, {0, 1}};
  Outline pentagram;
  for (int k = 0; k < 5; ++k) {
    const double angle = 4 * std::numbers::pi * k / 5;
    pentagram.push_back({std::cos(angle), std::sin(angle)});
  }
  Random random(3);
  for (const Outline& outline : {bow_tie, eight, pentagram}) {
    for (const Plane& plane : {Plane{}, random_plane(random, 1), random_plane(random, 1e-6)}) {
      const Cut result = cut(placed(outline, plane));
      EXPECT_FALSE(result.is_simple) << outline.size();
      EXPECT_EQ(result.faces.size(), outline.size() - 2);
    }
  }
}

TEST(Triangulate, APolygonThatIsNotPlanarIsCutWithoutFolds) {
  Random random(4);
  for (int round = 0; round < 200; ++round) {
    std::vector<Vertex> vertices = placed(star(5 + random.below(20), random), {});
    for (Vertex& v : vertices) v[2] = static_cast<float>(random.uniform(-0.02, 0.02));
    expect_covered(vertices, "bent");
  }
}

TEST(Triangulate, EachTriangleHasTheVertexThatIsNotFinite) {
  std::vector<Vertex> vertices = placed({{0, 0}, {1, 0}, {1, 1}, {0.5, 2}, {0, 1}}, {});
  vertices[3][1] = std::numeric_limits<float>::quiet_NaN();
  for (const Face& face : cut(vertices).faces)
    EXPECT_NE(std::find(face.begin(), face.end(), 3U), face.end());
}

TEST(Triangulate, ManyCorners) {
  Random random(5);
  expect_covered(placed(comb(tests::rounds(15'000)), random_plane(random, 1e-3)), "comb");
  expect_covered(placed(spiral(tests::rounds(20'000), 0.01), random_plane(random, 1e3)), "spiral");
  expect_covered(placed(skyline(tests::rounds(20'000), random), {}), "skyline");
}

// All of these took quadratic time: minutes at a million corners.
TEST(Triangulate, ManyCornersOfPolygonsThatCrossThemselves) {
  Random random(8);
  constexpr std::size_t kCorners = tests::rounds(300'000);
  Outline scattered, wound, repeated;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const double angle = 2.4 * static_cast<double>(i);
    scattered.push_back({random.uniform(), random.uniform()});
    wound.push_back({std::cos(angle), std::sin(angle)});
  }
  for (std::size_t i = 0; i < 40'000; ++i)
    repeated.push_back({static_cast<double>(i % 5), static_cast<double>(i * i % 7)});
  for (const Outline& outline : {scattered, wound, repeated}) {
    const Cut result = cut(placed(outline, {}));
    EXPECT_FALSE(result.is_simple) << outline.size();
    EXPECT_EQ(result.faces.size(), outline.size() - 2);
  }
}

TEST(Orientation, IsExactWhereDoublesAreNot) {
  Random random(6);
  for (int round = 0; round < 10'000; ++round) {
    std::array<std::array<std::int64_t, 2>, 3> p{};
    for (std::int64_t& x : p[0]) x = static_cast<std::int64_t>(random.below(1U << 24U));
    for (std::int64_t& x : p[1]) x = static_cast<std::int64_t>(random.below(1U << 24U));
    const auto t = static_cast<std::int64_t>(random.below(64)) - 32;
    for (std::size_t k = 0; k < 2; ++k)  // near the line, within what a float holds
      p[2][k] = (p[0][k] + t * (p[1][k] - p[0][k]) / 64) & 0xFFFFFF;
    const std::int64_t exact =
        (p[0][0] - p[2][0]) * (p[1][1] - p[2][1]) - (p[0][1] - p[2][1]) * (p[1][0] - p[2][0]);
    const double scale = std::exp2(random.uniform(-100, 100) > 0 ? 60 : -90);
    const auto point = [&](std::size_t i) {
      return PlanePoint{static_cast<double>(p[i][0]) * scale, static_cast<double>(p[i][1]) * scale};
    };
    const int sign = exact > 0 ? 1 : exact < 0 ? -1 : 0;
    ASSERT_EQ(orientation(point(0), point(1), point(2)), sign);
    ASSERT_EQ(exact_orientation(point(0), point(1), point(2)), sign);
  }
}

}  // namespace
}  // namespace sightline::client::importer
