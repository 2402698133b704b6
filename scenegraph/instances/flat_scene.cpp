// Decides which instances are flat, and bounds the errors of their transforms.
#include "scenegraph/instances/flat_scene.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "accel/kdtree/tree_memory.h"
#include "scenegraph/instances/instance_list.h"
#include "scenegraph/model/mesh.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::kdtree::Reference;
using accel::mesh::FlatPart;

/// A mesh of several instances is flat in each of them if it has at most this many triangles.
constexpr std::uint64_t kSmallMesh = 1000;
/// Instances with a larger condition are entered, so that a ray as they see it is off by much less
/// than its rounding to floats.
constexpr double kMostCondition = 1024;
/// The share of coordinates that transforms of points and rays may be off, for each unit of the
/// condition: more than the roundings of two transforms, and of their inversion.
constexpr double kErrorPerCondition = 0x1p-47;
/// Most of that for a flat instance, as a share of the scene's size: less than what its vertices
/// lose by rounding to floats.
constexpr double kMostError = 0x1p-26;
/// Scales of flat instances: directions and origins then stay in range in both frames.
constexpr double kLeastScale = 0x1p-60, kMostScale = 0x1p+60;

double largest(const accel::geometry::Vec3d& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// Sets the instance's transform, that of the part, and its error; false if the instance is to be
/// entered.
bool set_transform(const Instances& instances, const Instance& instance, double size,
                   model::Affine& world, FlatPart& part) {
  const accel::geometry::Vec3d& center = instances.center();
  world = instances.world_from_local(instance);
  const double condition = model::condition(world, instance.local_from_world);
  if (!(condition <= kMostCondition)) return false;
  model::Affine centered = world;
  for (std::size_t axis = 0; axis < 3; ++axis) centered.m[4 * axis + 3] -= center[axis];
  const accel::geometry::Aabb& box = instance.mesh->bounds();
  double terms = largest(center), scale = 0;
  for (std::size_t row = 0; row < 3; ++row) {
    double sum = std::fabs(world.m[4 * row + 3]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double entry = std::fabs(world.m[4 * row + axis]);
      scale = std::max(scale, entry);
      sum +=
          entry * static_cast<double>(std::max(std::fabs(box.lo[axis]), std::fabs(box.hi[axis])));
    }
    terms = std::max(terms, sum);
  }
  part.tree_from_local = centered.m;
  part.error = terms * condition * kErrorPerCondition;
  return part.error <= kMostError * size && scale >= kLeastScale && scale <= kMostScale;
}

/// A guess at what building the tree takes.
constexpr std::uint64_t kBytesPerFace = 150;

}  // namespace

void FlatScene::add_entered(std::vector<Reference> boxes, accel::kdtree::BuildCounters& built) {
  if (boxes.empty()) return;
  boxes_ = std::move(boxes);
  entered_ = std::make_unique<accel::lazy::LazyTree>(bounds_of(boxes_), boxes_.size(),
                                                     accel::split::default_rule(),
                                                     accel::lazy::source_of(boxes_));
  entered_->expand_all(built);
}

std::unique_ptr<const FlatScene> FlatScene::make(const Instances& instances,
                                                 const FlatScene* before,
                                                 accel::kdtree::BuildCounters& built,
                                                 const std::atomic<bool>* cancelled) {
  if (instances.size() < 2) return nullptr;  // a mesh's own tree is as good
  instances.open_all();
  std::unordered_map<const model::Mesh*, std::uint32_t> uses;
  for (std::size_t i = 0; i < instances.size(); ++i) ++uses[instances[i].mesh];
  const accel::wide::Frame& frame = instances.tree().frame();
  const double size =
      static_cast<double>(accel::wide::largest_coordinate(frame.bounds) / frame.scale);
  auto made = std::make_unique<FlatScene>();
  std::vector<FlatPart> parts;
  std::vector<Reference> entered;
  std::uint64_t faces = 0;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const Instance& instance = instances[i];
    if (instance.mask == 0) continue;
    const model::Mesh& mesh = *instance.mesh;
    model::Affine world;
    FlatPart part;
    if ((uses[&mesh] == 1 || mesh.triangles() <= kSmallMesh) && mesh.is_resident() &&
        mesh.builder().whole == nullptr && set_transform(instances, instance, size, world, part)) {
      part.placed.mesh = mesh.view();
      part.placed.local_from_scene = &instance.local_from_world.m;
      part.placed.scene_from_local = &made->transforms_.emplace_back(world).m;
      part.placed.node = instance.node;
      part.placed.instance = static_cast<std::uint32_t>(i);
      part.bounds = mesh.bounds();
      faces += mesh.faces();
      parts.push_back(part);
    } else {
      const accel::geometry::Aabb box = accel::geometry::widen_flat(instance.box);
      entered.push_back({box.lo, static_cast<std::uint32_t>(i), box.hi});
    }
  }
  if (parts.empty() || (before != nullptr && faces <= before->triangles().faces())) return nullptr;
  const accel::mesh::TreeBuilder& builder =
      instances[parts.front().placed.instance].mesh->builder();
  if (builder.memory != nullptr &&
      builder.memory->held() + faces * kBytesPerFace > builder.memory->low_water())
    return nullptr;
  for (const FlatPart& part : parts) made->meshes_.insert(instances[part.placed.instance].mesh);
  made->triangles_ = accel::mesh::FlatTree::make(parts, builder.rule, built, cancelled);
  if (made->triangles_ == nullptr) return nullptr;
  made->add_entered(std::move(entered), built);
  return made;
}

std::uint64_t FlatScene::bytes() const {
  return triangles_->bytes() + transforms_.size() * sizeof(model::Affine) +
         (entered_ == nullptr ? 0 : entered_->tree().bytes()) +
         boxes_.capacity() * sizeof(Reference);
}

}  // namespace sightline::scenegraph::instances
