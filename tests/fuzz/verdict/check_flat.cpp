#include "tests/fuzz/verdict/check_flat.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "scenegraph/instances/instance_list.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/support/random.h"

namespace sightline::tests {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using scenegraph::QueryKind;
using scenegraph::model::Affine;
using scenegraph::revision::Snapshot;

namespace {

Affine scaling(double x, double y, double z) {
  return Affine{{x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0}};
}

Affine rotation(Random& random) {
  const Vec3d x = random.direction();
  Vec3d y = cross(x, random.direction());
  y = y * (1 / std::sqrt(dot(y, y)));
  const Vec3d z = cross(x, y);
  return Affine{{x.x, y.x, z.x, 0, x.y, y.y, z.y, 0, x.z, y.z, z.z, 0}};
}

/// `size` is that of the mesh.
Affine take_frame(Random& random, double size) {
  Affine frame;
  if (random.below(4) != 0) frame = rotation(random);
  if (random.below(2) != 0) {
    const auto share = [&] { return random.uniform(-1, 1); };
    frame = compose(frame, Affine{{1, share(), share(), 0, 0, 1, share(), 0, 0, 0, 1, 0}});
  }
  const double most = static_cast<double>(std::array{0, 1, 3, 9}[random.below(4)]);
  const auto scale = [&] { return std::exp2(random.uniform(-most, most)); };
  const double mirror = random.below(2) == 0 ? 1 : -1;
  frame = compose(frame, scaling(mirror * scale(), scale(), scale()));
  if (random.below(2) != 0) {
    const double away = size * std::exp2(static_cast<double>(random.below(21)));
    for (std::size_t axis = 0; axis < 3; ++axis)
      frame.m[4 * axis + 3] = away * random.uniform(-1, 1);
  }
  return frame;
}

double size_of(const VerdictCase& asked) {
  double size = 0;
  for (const accel::geometry::Vec3f& v : asked.vertices)
    size = std::max(size, accel::geometry::max_norm(Vec3d(v)));
  return size;
}

struct Answers {
  std::vector<Hit> nearest, any, listed;
  std::vector<scenegraph::RayTally> counts, lists;
};

void make_flat(const scenegraph::instances::Instances& instances) {
  accel::kdtree::BuildCounters built;
  instances.make_flat(built);
}

/// All kinds of answers, by the flat tree or without one.
Answers answers_of(const Snapshot& snapshot, const std::vector<Ray>& rays, const VerdictCase& asked,
                   bool flat) {
  Answers out;
  out.nearest.resize(rays.size());
  out.any.resize(rays.size());
  out.counts.resize(rays.size());
  out.lists.resize(rays.size());
  const auto options = [&](QueryKind kind) {
    const auto& instances = snapshot.trees().static_tree();
    if (flat) {
      make_flat(instances);
    } else {
      instances.drop_flat();
    }
    scenegraph::TraceOptions made;
    made.kind = kind;
    made.culling = asked.culling;
    return made;
  };
  (void)trace(snapshot, rays, out.nearest, options(QueryKind::kClosest));
  (void)trace(snapshot, rays, out.any, options(QueryKind::kAny));
  (void)count_hits(snapshot, rays, out.counts, options(QueryKind::kCount));
  (void)list_hits(snapshot, rays, out.lists, out.listed, options(QueryKind::kAll));
  return out;
}

bool same(const Hit& a, const Hit& b) {
  if (a.state != b.state || a.state == accel::geometry::HitState::kInvalid)
    return a.state == b.state;
  return a.t == b.t && a.node == b.node && a.primitive == b.primitive && a.u == b.u && a.v == b.v;
}

}  // namespace

std::optional<std::string> check_flat(const VerdictCase& asked, bool& is_flat) {
  is_flat = false;
  const auto mesh = scenegraph::model::Mesh::make(asked.vertices, asked.faces);
  if (!mesh) return std::nullopt;
  Random random(asked.frames);
  std::array<Affine, 2> frames;
  std::vector<scenegraph::model::Update> updates;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i] = take_frame(random, size_of(asked));
    scenegraph::model::PutNode put;
    put.node = -static_cast<scenegraph::model::NodeRef>(i) - 1;
    put.mesh = *mesh;
    put.mesh_digest = "digest";
    put.parent_from_local = frames[i];
    updates.emplace_back(put);
  }
  scenegraph::Scene scene;
  if (!scene.apply(updates)) return std::nullopt;
  const auto snapshot = scene.snapshot();
  if (!scenegraph::build_all(*snapshot)) return std::nullopt;
  make_flat(snapshot->trees().static_tree());
  is_flat = snapshot->trees().static_tree().flat() != nullptr;
  if (!is_flat) return std::nullopt;
  std::vector<Ray> rays;
  for (const AskedRay& ray : asked.rays) {
    const Affine& frame = frames[random.below(frames.size())];
    rays.push_back(ray.ray);
    rays.back().origin = frame.point(ray.ray.origin);
    rays.back().direction = frame.direction(ray.ray.direction);
  }
  const Answers entered = answers_of(*snapshot, rays, asked, false),
                flat = answers_of(*snapshot, rays, asked, true);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const char* const wrong = !same(flat.nearest[i], entered.nearest[i])        ? "nearest hit"
                              : flat.any[i].state != entered.any[i].state       ? "any hit"
                              : flat.counts[i].count != entered.counts[i].count ? "count"
                              : flat.lists[i].count != entered.lists[i].count   ? "list"
                                                                                : nullptr;
    if (wrong != nullptr)
      return fmt::format("flat tree: ray {}: {}, t {:a}, not {:a}", i, wrong, flat.nearest[i].t,
                         entered.nearest[i].t);
  }
  const bool equal = std::equal(flat.listed.begin(), flat.listed.end(), entered.listed.begin(),
                                entered.listed.end(), same);
  return equal ? std::nullopt : std::optional<std::string>("flat tree: lists");
}

}  // namespace sightline::tests
