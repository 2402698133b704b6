// The oracle: doubles and boxes reject certain misses, 113 bits decide the rest.
#include "tests/support/brute_force.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "tests/support/exact_triangle.h"
#include "tests/support/quad.h"

namespace sightline::tests {

using accel::geometry::Vec3d;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// Boxes are widened by this share of the largest coordinate: far more than any rounding here.
constexpr double kBoxPad = 1e-9;

double largest(const Vec3d& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

scenegraph::model::Affine compose_in_double(const scenegraph::model::Affine& outer,
                                            const scenegraph::model::Affine& inner) {
  scenegraph::model::Affine product;
  for (std::size_t r = 0; r < 12; r += 4) {
    for (std::size_t c = 0; c < 4; ++c) {
      product.m[r + c] = outer.m[r] * inner.m[c] + outer.m[r + 1] * inner.m[4 + c] +
                         outer.m[r + 2] * inner.m[8 + c] + (c == 3 ? outer.m[r + 3] : 0);
    }
  }
  return product;
}

QuadVec row(const scenegraph::model::Affine& a, std::size_t first) {
  return widen({a.m[first], a.m[first + 1], a.m[first + 2]});
}

Quad determinant(const scenegraph::model::Affine& a) {
  return dot(row(a, 0), cross(row(a, 4), row(a, 8)));
}

void collect_subtree(const scenegraph::revision::Snapshot& snapshot, scenegraph::model::NodeId id,
                     const scenegraph::model::Affine& world_from_parent,
                     std::vector<PlacedMesh>& placed) {
  const scenegraph::model::Node* node = snapshot.find(id);
  const scenegraph::model::Affine world_from_local =
      compose_in_double(world_from_parent, node->parent_from_local);
  if (is_flat(node->parent_from_local)) return;
  if (node->mesh && !is_flat(world_from_local))
    placed.push_back({node->mesh->view(), world_from_local, id, node->mask});
  for (const scenegraph::model::NodeId child : node->children) {
    collect_subtree(snapshot, child, world_from_local, placed);
  }
}

bool has_area(const accel::geometry::MeshView& mesh, const accel::geometry::Face& face) {
  for (const std::uint32_t index : face) {
    if (index >= mesh.vertices.size() || !is_finite(mesh.vertices[index])) return false;
  }
  const scenegraph::model::Affine identity;
  const QuadVec a = transform(identity, mesh.vertices[face[0]]);
  const QuadVec n = cross(transform(identity, mesh.vertices[face[1]]) - a,
                          transform(identity, mesh.vertices[face[2]]) - a);
  return n.x != 0 || n.y != 0 || n.z != 0;
}

std::uint64_t spread_bits(std::uint64_t x) {
  std::uint64_t spread = 0;
  for (int bit = 0; bit < 16; ++bit) spread |= ((x >> bit) & 1u) << (3 * bit);
  return spread;
}

// The order only affects how tight the chunks' boxes are, not the results.
std::uint64_t morton(const Vec3d& p, const Vec3d& lo, const Vec3d& hi) {
  std::uint64_t code = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double extent = hi[axis] - lo[axis];
    const double share = extent > 0 ? (p[axis] - lo[axis]) / extent : 0;
    code |= spread_bits(static_cast<std::uint64_t>(std::clamp(share, 0.0, 1.0) * 65535)) << axis;
  }
  return code;
}

// Removes candidates that the query excludes; where rounding decides the side, both sides stay
// possible.
void cull(accel::geometry::Culling culling, std::vector<Candidate>& found) {
  if (culling == accel::geometry::Culling::kNone) return;
  const int culled = culling == accel::geometry::Culling::kBack ? 1 : -1;
  std::erase_if(found, [&](const Candidate& c) { return c.side == culled; });
  for (Candidate& c : found) c.borderline = c.borderline || c.side == 0;
}

bool is_valid(const accel::geometry::Ray& ray) {
  return is_finite(ray.origin) && is_finite(ray.direction) && ray.direction != Vec3d{} &&
         !std::isnan(ray.tmin) && !std::isnan(ray.tmax);
}

}  // namespace

bool is_flat(const scenegraph::model::Affine& a) {
  const QuadVec x = row(a, 0), y = row(a, 4), z = row(a, 8);
  const QuadVec yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
  const Quad det = dot(x, yz);
  const Quad squared =
      (dot(x, x) + dot(y, y) + dot(z, z)) * (dot(yz, yz) + dot(zx, zx) + dot(xy, xy));
  return !(squared <= Quad{1e24} * det * det) || det == 0;
}

std::vector<PlacedMesh> placed_meshes(const scenegraph::revision::Snapshot& snapshot) {
  std::vector<PlacedMesh> placed;
  for (const scenegraph::model::NodeId root : snapshot.roots()) {
    collect_subtree(snapshot, root, scenegraph::model::Affine{}, placed);
  }
  return placed;
}

// The ray's line, with its direction scaled so that the largest component is about 1.
struct BruteForce::Line {
  const accel::geometry::Ray& ray;
  Vec3d direction;

  explicit Line(const accel::geometry::Ray& r) : ray(r) {
    int exponent = 0;
    (void)std::frexp(largest(r.direction), &exponent);
    direction = {std::ldexp(r.direction.x, -exponent), std::ldexp(r.direction.y, -exponent),
                 std::ldexp(r.direction.z, -exponent)};
  }
};

void BruteForce::Box::grow(const Vec3d& p) {
  lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
  hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
}

BruteForce::BruteForce(std::vector<PlacedMesh> meshes, Tolerance tolerance)
    : tolerance_(tolerance) {
  instances_.resize(meshes.size());
  tbb::parallel_for(std::size_t{0}, meshes.size(),
                    [&](std::size_t i) { instances_[i] = make_instance(meshes[i]); });
}

BruteForce::BruteForce(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot,
                       Tolerance tolerance)
    : BruteForce(placed_meshes(*snapshot), tolerance) {
  snapshot_ = std::move(snapshot);
}

BruteForce::Instance BruteForce::make_instance(const PlacedMesh& placed) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const Box nothing{{kInf, kInf, kInf}, {-kInf, -kInf, -kInf}};
  Instance instance{placed, nothing, 0, determinant(placed.world_from_local) < 0, {}};
  const accel::geometry::MeshView& mesh = placed.mesh;

  std::vector<std::uint32_t> faces;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (has_area(mesh, mesh.faces[f])) faces.push_back(f);
  }
  const auto corner = [&](std::uint32_t face, std::size_t i) {
    return placed.world_from_local.point(Vec3d(mesh.vertices[mesh.faces[face][i]]));
  };
  Vec3d reach{};
  for (const std::uint32_t f : faces) {
    for (std::size_t i = 0; i < 3; ++i) {
      instance.box.grow(corner(f, i));
      const accel::geometry::Vec3f& v = mesh.vertices[mesh.faces[f][i]];
      for (std::size_t a = 0; a < 3; ++a) {
        reach[a] = std::max(reach[a], std::abs(static_cast<double>(v[a])));
      }
    }
  }
  const auto& m = placed.world_from_local.m;
  for (std::size_t r = 0; r < 12; r += 4) {
    instance.magnitude =
        std::max(instance.magnitude, std::abs(m[r]) * reach.x + std::abs(m[r + 1]) * reach.y +
                                         std::abs(m[r + 2]) * reach.z + std::abs(m[r + 3]));
  }

  std::vector<std::uint64_t> code(mesh.faces.size());
  for (const std::uint32_t f : faces) {
    code[f] = morton((corner(f, 0) + corner(f, 1) + corner(f, 2)) * (1.0 / 3), instance.box.lo,
                     instance.box.hi);
  }
  std::sort(faces.begin(), faces.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(code[a], a) < std::pair(code[b], b);
  });

  instance.chunks.resize((faces.size() + kLanes - 1) / kLanes);
  for (std::size_t k = 0; k < faces.size(); ++k) {
    Chunk& chunk = instance.chunks[k / kLanes];
    const std::size_t lane = chunk.count++;
    if (lane == 0) chunk.box = nothing;
    chunk.face[lane] = faces[k];
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d p = corner(faces[k], i);
      chunk.box.grow(p);
      for (std::size_t a = 0; a < 3; ++a) chunk.corner[3 * i + a][lane] = p[a];
    }
  }
  return instance;
}

// Whether the whole line stays clear of the box widened by `pad`. A line that meets the box itself
// is inside the widened slabs by pad / |d| on both sides, far more than any rounding below.
bool BruteForce::misses(const Box& box, const Line& line, double pad) {
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < 3; ++a) {
    const double o = line.ray.origin[a];
    const double d = line.direction[a];
    const double lo = box.lo[a] - pad, hi = box.hi[a] + pad;
    if (d == 0) {
      if (o < lo || o > hi) return true;
      continue;
    }
    const double s0 = (lo - o) / d, s1 = (hi - o) / d;
    enter = std::max(enter, std::min(s0, s1));
    leave = std::min(leave, std::max(s0, s1));
  }
  return enter > leave;
}

void BruteForce::test_chunk(const Instance& instance, const Chunk& chunk, const Line& line,
                            double scale, std::vector<Candidate>& found) const {
  const Vec3d o = line.ray.origin;
  const Vec3d d = line.direction;
  const double reach =
      2 * std::max(largest(chunk.box.lo - o), largest(chunk.box.hi - o));  // >= any |corner - o|
  // Covers rounding of the volume, and of corners that are off by a few epsilon times `scale`.
  const double doubt =
      2 * (64 * kEpsilon * reach * reach + 2 * (tolerance_.edge + 64 * kEpsilon) * scale * reach);

  std::array<unsigned char, kLanes> suspect{};
  const auto& p = chunk.corner;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Vec3d a{p[0][i] - o.x, p[1][i] - o.y, p[2][i] - o.z};
    const Vec3d b{p[3][i] - o.x, p[4][i] - o.y, p[5][i] - o.z};
    const Vec3d c{p[6][i] - o.x, p[7][i] - o.y, p[8][i] - o.z};
    const double va = dot(d, cross(b, c)), vb = dot(d, cross(c, a)), vc = dot(d, cross(a, b));
    const double low = std::min(std::min(va, vb), vc), high = std::max(std::max(va, vb), vc);
    suspect[i] = !(low < -doubt && high > doubt);
  }
  for (std::size_t i = 0; i < chunk.count; ++i) {
    if (!suspect[i]) continue;
    const PlacedMesh& placed = instance.placed;
    const accel::geometry::Face& face = placed.mesh.faces[chunk.face[i]];
    std::array<QuadVec, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = transform(placed.world_from_local, placed.mesh.vertices[face[k]]);
    }
    auto candidate = test_triangle(line.ray, corners, scale, tolerance_);
    if (!candidate) continue;
    if (instance.is_mirrored) {
      candidate->normal = candidate->normal * -1.0;
      candidate->side = -candidate->side;
    }
    candidate->node = placed.node;
    candidate->primitive = chunk.face[i];
    found.push_back(*candidate);
  }
}

Reference BruteForce::trace_all(const accel::geometry::Ray& ray, const Filter& filter) const {
  Reference reference;
  reference.invalid = !is_valid(ray);
  if (reference.invalid) return reference;

  const Line line(ray);
  auto& found = reference.candidates;
  for (const Instance& instance : instances_) {
    if ((instance.placed.mask & ray.mask) == 0 || instance.chunks.empty()) continue;
    if (std::binary_search(filter.hidden.begin(), filter.hidden.end(), instance.placed.node))
      continue;
    const double scale = std::max(instance.magnitude, largest(ray.origin));
    const double pad = kBoxPad * scale;
    if (misses(instance.box, line, pad)) continue;
    for (const Chunk& chunk : instance.chunks) {
      if (!misses(chunk.box, line, pad)) test_chunk(instance, chunk, line, scale, found);
    }
  }

  cull(filter.culling, found);
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.t, a.node, a.primitive) < std::tie(b.t, b.node, b.primitive);
  });
  return reference;
}

Reference BruteForce::trace(const accel::geometry::Ray& ray, const Filter& filter) const {
  return nearest_part(trace_all(ray, filter));
}

Reference nearest_part(Reference all) {
  auto& found = all.candidates;
  const auto firm = std::find_if(found.begin(), found.end(),
                                 [](const Candidate& c) { return c.accepted && !c.borderline; });
  if (firm == found.end()) return all;
  const double last = firm->t + firm->t_tolerance;
  found.erase(std::remove_if(firm, found.end(),
                             [&](const Candidate& c) { return c.t - c.t_tolerance > last; }),
              found.end());
  return all;
}

std::vector<Reference> BruteForce::trace(std::span<const accel::geometry::Ray> rays) const {
  std::vector<Reference> references(rays.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), 4), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) references[i] = trace(rays[i]);
  });
  return references;
}

}  // namespace sightline::tests
