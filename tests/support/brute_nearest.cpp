// The oracle for closest points: bounds in doubles, then 113 bits, then rationals.
#include "tests/support/brute_nearest.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "tests/support/distance_bounds.h"
#include "tests/support/equal_faces.h"
#include "tests/support/quad_distance.h"
#include "tests/support/rational_distance.h"

namespace sightline::tests {

using accel::geometry::Vec3d;

namespace {

constexpr double kDoubleUnit = Precision<double>::kUnit;
// More than a component that counts as zero can move a point.
constexpr double kTinyMove = 0x1p-240;

bool face_exists(const accel::geometry::MeshView& mesh, const accel::geometry::Face& face) {
  return std::all_of(face.begin(), face.end(), [&](std::uint32_t v) {
    return v < mesh.vertices.size() && is_finite(mesh.vertices[v]);
  });
}

Vec3d world_corner(const PlacedMesh& placed, std::uint32_t face, std::size_t corner) {
  return placed.world_from_local.point(
      Vec3d(placed.mesh.vertices[placed.mesh.faces[face][corner]]));
}

Vec3d least_of(const Vec3d& a, const Vec3d& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3d greatest_of(const Vec3d& a, const Vec3d& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

double largest_terms_of(const PlacedMesh& placed, std::uint32_t face) {
  double largest = 0;
  for (const std::uint32_t index : placed.mesh.faces[face]) {
    const Vec3d v(placed.mesh.vertices[index]);
    for (std::size_t row = 0; row < 12; row += 4) {
      const double* m = &placed.world_from_local.m[row];
      largest = std::max(largest, std::abs(m[0] * v.x) + std::abs(m[1] * v.y) +
                                      std::abs(m[2] * v.z) + std::abs(m[3]));
    }
  }
  return largest;
}

}  // namespace

BruteNearest::BruteNearest(std::vector<PlacedMesh> meshes) {
  instances_.resize(meshes.size());
  tbb::parallel_for(std::size_t{0}, meshes.size(),
                    [&](std::size_t i) { instances_[i] = make_instance(meshes[i]); });
}

BruteNearest::BruteNearest(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot)
    : BruteNearest(placed_meshes(*snapshot)) {
  snapshot_ = std::move(snapshot);
}

BruteNearest::Instance BruteNearest::make_instance(const PlacedMesh& placed) {
  Instance instance{placed, 0, {}};
  std::vector<std::uint32_t> faces;
  for (std::uint32_t f = 0; f < placed.mesh.faces.size(); ++f) {
    if (!face_exists(placed.mesh, placed.mesh.faces[f])) continue;
    faces.push_back(f);
    instance.magnitude = std::max(instance.magnitude, largest_terms_of(placed, f));
  }
  make_chunks(instance, faces);
  return instance;
}

// Halves the faces at the median of the widest axis. Answers do not depend on how they are grouped.
void BruteNearest::make_chunks(Instance& instance, std::span<std::uint32_t> faces) {
  if (faces.empty()) return;
  const PlacedMesh& placed = instance.placed;
  Box box{world_corner(placed, faces[0], 0), world_corner(placed, faces[0], 0)};
  for (const std::uint32_t f : faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      box.lo = least_of(box.lo, world_corner(placed, f, k));
      box.hi = greatest_of(box.hi, world_corner(placed, f, k));
    }
  }
  if (faces.size() > kLanes) {
    const Vec3d extent = box.hi - box.lo;
    const std::size_t axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                             : extent.y >= extent.z                       ? 1
                                                                          : 2;
    const auto center = [&](std::uint32_t f) {
      return world_corner(placed, f, 0)[axis] + world_corner(placed, f, 1)[axis] +
             world_corner(placed, f, 2)[axis];
    };
    const std::size_t half = (faces.size() / 2 + kLanes - 1) / kLanes * kLanes;
    std::nth_element(faces.begin(), faces.begin() + static_cast<std::ptrdiff_t>(half), faces.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return center(a) < center(b); });
    make_chunks(instance, faces.first(half));
    make_chunks(instance, faces.subspan(half));
    return;
  }
  Chunk& chunk = instance.chunks.emplace_back();
  chunk.box = box;
  for (const std::uint32_t f : faces) {
    const std::size_t lane = chunk.count++;
    chunk.face[lane] = f;
    for (std::size_t k = 0; k < 3; ++k) chunk.corner[lane][k] = world_corner(placed, f, k);
  }
}

struct BruteNearest::NearChunk {
  double lower;
  const Instance* instance;
  const Chunk* chunk;

  bool operator<(const NearChunk& other) const { return lower > other.lower; }  // Nearest on top
};

// At most the distance of p from what is within `pad` of the box. 0 if the square overflows.
double BruteNearest::distance_below(const Box& box, const Vec3d& p, double pad) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double gap = std::max({box.lo[axis] - p[axis], p[axis] - box.hi[axis], 0.0});
    square += gap * gap;
  }
  if (!(square < std::numeric_limits<double>::infinity())) return 0;
  return std::max(std::sqrt(square) * (1 - 0x1p-48) - pad, 0.0);
}

double BruteNearest::exact_distance(const Instance& instance, std::uint32_t face, const Vec3d& p) {
  const PlacedMesh& placed = instance.placed;
  const accel::geometry::Face& index = placed.mesh.faces[face];
  const accel::geometry::Vec3f &a = placed.mesh.vertices[index[0]],
                               &b = placed.mesh.vertices[index[1]],
                               &c = placed.mesh.vertices[index[2]];
  const auto quick = quad_distance(p, placed.world_from_local, a, b, c);
  return quick ? *quick : rational_distance(p, placed.world_from_local.m, a, b, c);
}

// Calls found(instance, face, lower, upper) with bounds of the distance of each face of the chunk.
template <class Found>
void BruteNearest::visit_chunk(const NearChunk& near, const Vec3d& p, Found& found) {
  const Chunk& chunk = *near.chunk;
  double reach = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    reach = std::max(
        {reach, std::abs(chunk.box.lo[axis] - p[axis]), std::abs(chunk.box.hi[axis] - p[axis])});
  }
  const bool is_bounded = reach > 0x1p-150 && reach < 0x1p+149;
  // A corner is at most twice `reach` away. A world coordinate is off by five units of the terms,
  // its difference to p by one unit of itself.
  const double slack = 80 * kDoubleUnit * reach + 16 * kDoubleUnit * near.instance->magnitude;
  for (std::size_t lane = 0; lane < chunk.count; ++lane) {
    DistanceBounds<double> bounds{0, std::numeric_limits<double>::infinity()};
    if (is_bounded) {
      const auto& corner = chunk.corner[lane];
      bounds = distance_bounds<double>({corner[0] - p, corner[1] - p, corner[2] - p}, slack);
    }
    found(*near.instance, chunk.face[lane], bounds.lower, bounds.upper);
  }
}

// All faces that may be within `limit`, which `found` may lower meanwhile: near chunks first.
template <class Found>
void BruteNearest::visit(const Vec3d& p, const double& limit, const NodeFilter& filter,
                         Found&& found) const {
  std::vector<NearChunk> chunks;
  for (const Instance& instance : instances_) {
    const PlacedMesh& placed = instance.placed;
    if ((placed.mask & filter.mask) == 0) continue;
    if (filter.accepts && !filter.accepts(placed.node)) continue;
    const double pad = 16 * kDoubleUnit * instance.magnitude + kTinyMove;
    for (const Chunk& chunk : instance.chunks) {
      const double lower = distance_below(chunk.box, p, pad);
      if (lower <= limit) chunks.push_back({lower, &instance, &chunk});
    }
  }
  std::priority_queue<NearChunk> queue({}, std::move(chunks));
  for (; !queue.empty() && queue.top().lower <= limit; queue.pop()) {
    visit_chunk(queue.top(), p, found);
  }
}

/// The first `most` faces in order, and more that are not nearer; among them all that are as far as
/// the last.
std::vector<NearFace> BruteNearest::first_and_ties(const Vec3d& p, double max_distance,
                                                   std::size_t most,
                                                   const NodeFilter& filter) const {
  struct Suspect {
    double lower;
    const Instance* instance;
    std::uint32_t face;
  };
  std::vector<Suspect> suspects;
  std::priority_queue<double> uppers;  // The `most` least, the largest on top
  double limit = max_distance;
  visit(p, limit, filter,
        [&](const Instance& instance, std::uint32_t face, double lower, double upper) {
          if (lower > limit) return;
          suspects.push_back({lower, &instance, face});
          if (most == kNoLimit) return;
          uppers.push(upper);
          if (uppers.size() > most) uppers.pop();
          if (uppers.size() == most) limit = std::min(limit, uppers.top());
        });
  std::vector<NearFace> faces;
  EqualFaces decided;
  for (const Suspect& suspect : suspects) {
    if (suspect.lower > limit) continue;
    const double distance = decided.distance_of(suspect.instance->placed, suspect.face, [&] {
      return exact_distance(*suspect.instance, suspect.face, p);
    });
    if (distance > max_distance) continue;
    faces.push_back({distance, suspect.instance->placed.node, suspect.face});
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

std::vector<NearFace> BruteNearest::all(const Vec3d& p, double max_distance, std::size_t most,
                                        const NodeFilter& filter) const {
  if (most == 0) return {};
  std::vector<NearFace> faces = first_and_ties(p, max_distance, most, filter);
  if (faces.size() > most) faces.resize(most);
  return faces;
}

std::vector<NearFace> BruteNearest::all_closest(const Vec3d& p, double max_distance,
                                                const NodeFilter& filter) const {
  std::vector<NearFace> faces = first_and_ties(p, max_distance, 1, filter);
  const auto farther = std::find_if(faces.begin(), faces.end(), [&](const NearFace& face) {
    return face.distance > faces.front().distance;
  });
  faces.erase(farther, faces.end());
  return faces;
}

std::optional<NearFace> BruteNearest::closest(const Vec3d& p, double max_distance,
                                              const NodeFilter& filter) const {
  const std::vector<NearFace> first = all(p, max_distance, 1, filter);
  if (first.empty()) return std::nullopt;
  return first[0];
}

std::uint64_t BruteNearest::count(const Vec3d& p, double max_distance,
                                  const NodeFilter& filter) const {
  std::uint64_t within = 0;
  visit(p, max_distance, filter,
        [&](const Instance& instance, std::uint32_t face, double lower, double upper) {
          if (lower > max_distance) return;
          if (upper <= max_distance || exact_distance(instance, face, p) <= max_distance) ++within;
        });
  return within;
}

std::vector<std::optional<NearFace>> BruteNearest::closest(std::span<const Vec3d> points,
                                                           double max_distance,
                                                           const NodeFilter& filter) const {
  std::vector<std::optional<NearFace>> nearest(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 4), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      nearest[i] = closest(points[i], max_distance, filter);
    }
  });
  return nearest;
}

}  // namespace sightline::tests
