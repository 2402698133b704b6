// Sorts edges by their vertices, and casts lines.
#include "client/importer/closedness.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "client/importer/finite.h"

namespace sightline::client::importer {
namespace {

constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();
using Meshes = std::span<const ImportedMesh* const>;
using Vector = std::array<double, 3>;

// Numbers positions: vertices at the same position get the same number.
class Positions {
 public:
  explicit Positions(std::size_t most) : table_(std::bit_ceil(2 * most + 1), kFree) {}

  std::uint32_t number_of(const Vertex& v) {
    for (std::size_t slot = hash(v);; ++slot) {
      std::uint32_t& number = table_[slot & (table_.size() - 1)];
      if (number == kFree) {
        number = static_cast<std::uint32_t>(points_.size());
        points_.push_back(v);
        return number;
      }
      if (points_[number] == v) return number;
    }
  }

  std::size_t size() const { return points_.size(); }

 private:
  static std::size_t hash(const Vertex& v) {
    std::uint64_t h = 0;
    for (const float x : v) {
      h = (h ^ std::bit_cast<std::uint32_t>(x + 0.0F)) * 0x9E3779B97F4A7C15U;  // -0 is 0
      h ^= h >> 32U;
    }
    return h;
  }

  std::vector<std::uint32_t> table_;
  std::vector<Vertex> points_;
};

struct Edge {
  std::uint32_t to;    // the larger one of its positions
  std::uint32_t face;  // its number in all meshes
};

// Calls use(positions, face) for each triangle that counts, with the number of its face in all
// meshes.
template <class Use>
void each_triangle(Meshes meshes, const std::vector<std::uint32_t>& position_of, const Use& use) {
  std::uint32_t face = 0;
  std::size_t first_vertex = 0;
  for (const ImportedMesh* const mesh : meshes) {
    for (const Face& corners : mesh->faces) {
      const std::uint32_t number = face++;
      if (corners[0] == kNoVertex) continue;
      const Face triangle{position_of[first_vertex + corners[0]],
                          position_of[first_vertex + corners[1]],
                          position_of[first_vertex + corners[2]]};
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
        continue;
      if (std::find(triangle.begin(), triangle.end(), kFree) == triangle.end())
        use(triangle, number);
    }
    first_vertex += mesh->vertices.size();
  }
}

// Calls use(from, to) for its three edges, with the smaller position first.
template <class Use>
void each_edge(const Face& triangle, const Use& use) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
    use(std::min(a, b), std::max(a, b));
  }
}

// The first face of those that have an edge alone, and how many such edges there are. The edges
// begin at one position.
void count_single(std::span<Edge> edges, std::uint64_t& count, std::uint32_t& first_face) {
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.to < b.to; });
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].to == edges[i].to) ++end;
    if (end == i + 1) {
      ++count;
      first_face = std::min(first_face, edges[i].face);
    }
    i = end;
  }
}

struct Triangle {
  Vector a, b, c;
};

Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vector& v) { return std::sqrt(dot(v, v)); }

std::vector<Triangle> triangles_of(Meshes meshes) {
  std::vector<Triangle> out;
  for (const ImportedMesh* const mesh : meshes) {
    const auto at = [&](std::uint32_t v) {
      const Vertex& p = mesh->vertices[v];
      return Vector{static_cast<double>(p[0]), static_cast<double>(p[1]),
                    static_cast<double>(p[2])};
    };
    for (const Face& face : mesh->faces) {
      if (face[0] == kNoVertex) continue;
      if (!std::all_of(face.begin(), face.end(),
                       [&](std::uint32_t v) { return is_finite(mesh->vertices[v]); }))
        continue;
      out.push_back({at(face[0]), at(face[1]), at(face[2])});
    }
  }
  return out;
}

enum class Crossing { kNone, kOne, kUnsure };

// The line goes through `origin` along `direction`, which is of unit length.
Crossing cross_line(const Triangle& t, const Vector& origin, const Vector& direction) {
  constexpr double kNearEdge = 1e-7;  // share of the triangle's size
  const Vector a = minus(t.a, origin), b = minus(t.b, origin), c = minus(t.c, origin);
  const double u = dot(direction, cross(a, b)), v = dot(direction, cross(b, c)),
               w = dot(direction, cross(c, a));
  const double size = std::max({length(a), length(b), length(c)});
  const double unsure = kNearEdge * size * size;
  if (std::abs(u) > unsure && std::abs(v) > unsure && std::abs(w) > unsure)
    return (u > 0) == (v > 0) && (v > 0) == (w > 0) ? Crossing::kOne : Crossing::kNone;
  const bool may_be_in = std::min({u, v, w}) >= -unsure || std::max({u, v, w}) <= unsure;
  return may_be_in ? Crossing::kUnsure : Crossing::kNone;
}

}  // namespace

OpenEdges open_edges(Meshes meshes) {
  std::size_t vertices = 0;
  for (const ImportedMesh* const mesh : meshes) vertices += mesh->vertices.size();
  Positions positions(vertices);
  std::vector<std::uint32_t> position_of;
  position_of.reserve(vertices);
  for (const ImportedMesh* const mesh : meshes) {
    for (const Vertex& v : mesh->vertices)
      position_of.push_back(is_finite(v) ? positions.number_of(v) : kFree);
  }
  std::vector<std::uint32_t> first(positions.size() + 1);
  each_triangle(meshes, position_of, [&](const Face& triangle, std::uint32_t) {
    each_edge(triangle, [&](std::uint32_t from, std::uint32_t) { ++first[from + 1]; });
  });
  for (std::size_t i = 0; i + 1 < first.size(); ++i) first[i + 1] += first[i];
  std::vector<Edge> edges(first.back());
  std::vector<std::uint32_t> next(first.begin(), first.end());
  each_triangle(meshes, position_of, [&](const Face& triangle, std::uint32_t face) {
    each_edge(triangle, [&](std::uint32_t from, std::uint32_t to) {
      edges[next[from]++] = {to, face};
    });
  });
  OpenEdges out;
  std::uint32_t face = kFree;
  for (std::size_t i = 0; i + 1 < first.size(); ++i) {
    count_single(std::span(edges).subspan(first[i], first[i + 1] - first[i]), out.count, face);
  }
  if (out.count == 0) return out;
  out.face = face;
  while (out.face >= meshes[out.mesh]->faces.size()) out.face -= meshes[out.mesh++]->faces.size();
  return out;
}

OddLines odd_lines(Meshes meshes) {
  constexpr std::size_t kLines = 48, kMostTests = 4'000'000;
  const std::vector<Triangle> triangles = triangles_of(meshes);
  OddLines out;
  if (triangles.empty()) return out;
  const std::size_t lines = std::clamp(kMostTests / triangles.size(), std::size_t{4}, kLines);
  std::mt19937_64 random(triangles.size());
  const auto share = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
  for (std::size_t k = 0; k < lines; ++k) {
    const Triangle& t = triangles[random() % triangles.size()];
    const double u = share(), v = share() * (1 - u);
    Vector origin{}, direction{};
    for (std::size_t i = 0; i < 3; ++i) {
      origin[i] = t.a[i] + u * (t.b[i] - t.a[i]) + v * (t.c[i] - t.a[i]);
      direction[i] = 2 * share() - 1;
    }
    const double norm = length(direction);
    for (double& x : direction) x /= norm;
    std::uint64_t crossings = 0;
    const bool is_sure =
        std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& other) {
          const Crossing crossing = cross_line(other, origin, direction);
          crossings += crossing == Crossing::kOne ? 1 : 0;
          return crossing != Crossing::kUnsure;
        });
    if (!is_sure) continue;
    ++out.lines;
    out.odd += crossings % 2;
  }
  return out;
}

}  // namespace sightline::client::importer
