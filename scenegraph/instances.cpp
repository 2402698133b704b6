// From the hierarchy to a flat list of instances.
#include "scenegraph/instances.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_set>

#include "scenegraph/snapshot.h"

namespace sightline::scenegraph {
namespace {

/// Entering an instance costs a transform and a few steps in its tree, whose depth goes with the
/// logarithm of its size.
constexpr std::uint32_t kEnterPrice = 4;

struct Placed {
  Affine world_from_local;
  WorldBounds box;
};

double magnitude(const WorldBounds& b) {
  double m = 0;
  for (std::size_t a = 0; a < 3; ++a)
    m = std::fmax(m, std::fmax(std::fabs(b.lo[a]), std::fabs(b.hi[a])));
  return m;
}

/// The box of the mesh's box, padded for the rounding of the transform and of its inverse.
WorldBounds world_box(const Affine& world_from_local, const Affine& local_from_world,
                      const accel::Aabb& box) {
  WorldBounds bounds;
  for (int corner = 0; corner < 8; ++corner) {
    bounds.grow(world_from_local.point({static_cast<double>(corner & 1 ? box.hi.x : box.lo.x),
                                        static_cast<double>(corner & 2 ? box.hi.y : box.lo.y),
                                        static_cast<double>(corner & 4 ? box.hi.z : box.lo.z)}));
  }
  const double pad = magnitude(bounds) * condition(world_from_local, local_from_world) * 0x1p-48;
  bounds.lo = bounds.lo - Vec3d{pad, pad, pad};
  bounds.hi = bounds.hi + Vec3d{pad, pad, pad};
  return bounds;
}

/// Outward, through two roundings: the subtraction and the narrowing.
accel::Aabb relative_box(const WorldBounds& world, const Vec3d& center) {
  accel::Aabb box;
  for (std::size_t a = 0; a < 3; ++a) {
    const double lo = world.lo[a] - center[a], hi = world.hi[a] - center[a];
    box.lo[a] = accel::round_down(lo - std::fabs(lo) * 0x1p-50);
    box.hi[a] = accel::round_up(hi + std::fabs(hi) * 0x1p-50);
  }
  return accel::widen_flat(box);
}

std::uint32_t price(const Mesh& mesh) {
  return kEnterPrice + static_cast<std::uint32_t>(std::bit_width(mesh.triangles()));
}

}  // namespace

void WorldBounds::grow(const Vec3d& p) {
  for (std::size_t a = 0; a < 3; ++a) {
    lo[a] = std::min(lo[a], p[a]);
    hi[a] = std::max(hi[a], p[a]);
  }
}

Affine world_from_local(const Snapshot& snapshot, const Node& node) {
  std::vector<const Node*> chain;
  for (const Node* n = &node; n != nullptr; n = n->parent == 0 ? nullptr : snapshot.find(n->parent))
    chain.push_back(n);
  Affine world = chain.back()->parent_from_local;
  for (auto n = chain.rbegin() + 1; n != chain.rend(); ++n)
    world = compose(world, (*n)->parent_from_local);
  return world;
}

Instances::Instances(const Snapshot& snapshot) {
  std::vector<WorldBounds> boxes;
  WorldBounds all;
  std::unordered_set<const Mesh*> seen;
  // Depth first with the transform of the way down.
  struct Visit {
    NodeId node;
    Affine world_from_parent;
  };
  std::vector<Visit> stack;
  for (auto root = snapshot.roots().rbegin(); root != snapshot.roots().rend(); ++root)
    stack.push_back({*root, {}});
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const Node& node = *snapshot.find(visit.node);
    const Affine world = node.parent == 0
                             ? node.parent_from_local
                             : compose(visit.world_from_parent, node.parent_from_local);
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
      stack.push_back({*child, world});
    if (node.mesh == nullptr) continue;
    if (seen.insert(node.mesh.get()).second) meshes_.push_back(node.mesh.get());
    if (node.mesh->bounds().empty()) continue;
    const std::optional<Affine> local_from_world = inverse(world);
    if (!local_from_world) continue;  // refused when the node was put: see Scene::apply
    boxes.push_back(world_box(world, *local_from_world, node.mesh->bounds()));
    all.grow(boxes.back().lo);
    all.grow(boxes.back().hi);
    list_.push_back({*local_from_world,
                     mirrors(world),
                     {},
                     node.id,
                     node.mask,
                     node.mesh.get(),
                     node.entered.get()});
  }
  if (!all.empty()) center_ = (all.lo + all.hi) * 0.5;
  accel::Aabb bounds;
  for (std::size_t i = 0; i < list_.size(); ++i) {
    list_[i].box = relative_box(boxes[i], center_);
    bounds.grow(list_[i].box);
  }
  const auto references = [this](std::size_t, accel::BuildCounters& counters) {
    counters.touches_prepare += list_.size();
    accel::BoxList refs(list_.size());
    for (std::size_t i = 0; i < list_.size(); ++i) {
      const Instance& instance = list_[i];
      refs.all()[i] = {instance.box.lo, static_cast<std::uint32_t>(i), instance.box.hi,
                       price(*instance.mesh)};
    }
    return refs;
  };
  tree_ = std::make_unique<accel::LazyTree>(bounds, list_.size(), list_.size(),
                                            accel::default_builder(),
                                            accel::ReferenceSource{.list = references});
}

}  // namespace sightline::scenegraph
