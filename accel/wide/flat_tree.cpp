// Copies blocks into the scene's coordinates, and joins them to one tree.
#include "accel/wide/flat_tree.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <tbb/parallel_for.h>

#include "accel/blocks/block.h"
#include "accel/blocks/box_hierarchy.h"

namespace sightline::accel::wide {
namespace {

using blocks::Block;
using blocks::Node;
using geometry::Aabb;
using geometry::Vec3d;
using kdtree::Slot;

Vec3d at(const Matrix& m, const Vec3d& p) {
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

bool is_set(const std::atomic<bool>* cancelled) {
  return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
}

bool is_mirrored(const Matrix& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
             m[2] * (m[4] * m[9] - m[5] * m[8]) <
         0;
}

/// A box around the image of a box, rounded outward.
Aabb mapped(const Matrix& m, const Vec3d& lo, const Vec3d& hi) {
  Aabb out;
  for (std::size_t row = 0; row < 3; ++row) {
    double least = m[4 * row + 3], most = least;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double a = m[4 * row + axis] * lo[axis], b = m[4 * row + axis] * hi[axis];
      least += std::min(a, b);
      most += std::max(a, b);
    }
    out.lo[row] = geometry::round_down(least);
    out.hi[row] = geometry::round_up(most);
  }
  return out;
}

/// The leaves of some meshes, and their memory.
struct Moved {
  std::vector<Node> leaves;
  blocks::Chunks words{blocks::kHugePage};
  std::size_t blocks = 0;
  double error = 0;  ///< The largest rounding of a coordinate.

  /// Adds a leaf that is the list of one instance.
  void add_list(std::uint32_t instance, const Aabb& box) {
    auto* const list = static_cast<std::uint32_t*>(words.take(2 * sizeof(std::uint32_t)));
    list[0] = 1;
    list[1] = instance;
    Node& leaf = leaves.emplace_back();
    leaf.box = box;
    leaf.words = 2;
    leaf.leaf_words = list;
  }
};

/// Copies the blocks of one mesh.
class Move {
 public:
  explicit Move(const FlatPart& part, std::uint32_t number, Moved& to)
      : part_(part), number_(number), mirrored_(is_mirrored(part.tree_from_local)), to_(to) {}

  void copy() { add(kdtree::load(part_.tree->root()), part_.frame->bounds); }

 private:
  void add(Slot slot, const Aabb& box) {
    if (!slot) return;
    if (slot.is_finished()) slot = slot.finished()->root();
    if (slot.is_block()) return add_block(slot.words(), box);
    if (slot.is_node()) {
      for (std::size_t i = 0; i < kdtree::kWidth; ++i)
        add(slot.node()->child(i), slot.node()->box(i));
    } else if (slot.is_deferred() || !slot.list().empty()) {
      to_.add_list(part_.placed.instance, placed(box));
    }
  }

  /// A box of the mesh's tree, in the flat tree.
  Aabb placed(const Aabb& box) const {
    const Vec3d center(part_.frame->center);
    return mapped(part_.tree_from_local, center + Vec3d(box.lo), center + Vec3d(box.hi));
  }

  void add_block(const std::uint32_t* from, const Aabb& box) {
    const Block block(from);
    const std::size_t size = Block::words_with_mesh(block.triangles, block.vertices);
    auto* const to = static_cast<std::uint32_t*>(to_.words.take(size * sizeof(std::uint32_t)));
    const Vec3d center(part_.frame->center);
    const std::size_t before_ids = 1 + 3 * std::size_t{block.vertices};
    to[0] = from[0];
    auto* const vertices = reinterpret_cast<float*>(to + 1);
    Aabb around;
    for (std::size_t i = 0; i < block.vertices; ++i) {
      const Vec3d exact = at(part_.tree_from_local, Vec3d(block.vertex(i)) + center);
      geometry::Vec3f rounded;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rounded[axis] = static_cast<float>(exact[axis]);
        vertices[axis * block.vertices + i] = rounded[axis];
        to_.error =
            std::max(to_.error, std::fabs(exact[axis] - static_cast<double>(rounded[axis])));
      }
      around.grow(Aabb{rounded, rounded});
    }
    const std::size_t corners = Block::corner_words(block.triangles);
    std::memcpy(to + before_ids, from + before_ids, 3 * corners * sizeof(std::uint32_t));
    if (mirrored_) {
      std::memcpy(to + before_ids + corners, from + before_ids + 2 * corners,
                  corners * sizeof(std::uint32_t));
      std::memcpy(to + before_ids + 2 * corners, from + before_ids + corners,
                  corners * sizeof(std::uint32_t));
    }
    std::uint32_t* next = to + before_ids + 3 * corners;
    for (std::size_t i = 0; i < block.triangles; ++i) *next++ = block.id(i) + part_.placed.first;
    *next++ = number_;
    while (next < to + size) *next++ = 0;
    const Aabb part = placed(box);
    Node& leaf = to_.leaves.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Rounding may leave nothing of a flat box.
      leaf.box.lo[axis] = std::min(std::max(around.lo[axis], part.lo[axis]), around.hi[axis]);
      leaf.box.hi[axis] = std::max(std::min(around.hi[axis], part.hi[axis]), around.lo[axis]);
    }
    leaf.words = static_cast<std::uint32_t>(size);
    leaf.leaf_words = to;
    ++to_.blocks;
  }

  const FlatPart& part_;
  const std::uint32_t number_;
  const bool mirrored_;
  Moved& to_;
};

/// Meshes that one thread copies: consecutive ones with about this many triangles.
constexpr std::size_t kTrianglesPerTask = 16384;

/// The first mesh of each task, and the number of meshes.
std::vector<std::size_t> tasks_of(std::span<const FlatPart> parts) {
  std::vector<std::size_t> first{0};
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    triangles += parts[i].placed.mesh.faces.size();
    if (triangles < kTrianglesPerTask) continue;
    first.push_back(i + 1);
    triangles = 0;
  }
  if (first.back() != parts.size()) first.push_back(parts.size());
  return first;
}

/// Gives the meshes numbers; false if there are too many triangles.
bool number(std::span<FlatPart> parts) {
  std::uint64_t first = 0;
  for (FlatPart& part : parts) {
    part.placed.first = static_cast<std::uint32_t>(first);
    first += part.placed.mesh.faces.size();
    if (first > std::numeric_limits<std::uint32_t>::max()) return false;
  }
  return true;
}

}  // namespace

std::unique_ptr<const FlatTree> FlatTree::make(std::span<FlatPart> parts,
                                               std::span<const ClosedInstance> closed,
                                               std::size_t least,
                                               const std::atomic<bool>* cancelled) {
  if (parts.empty() || !number(parts)) return nullptr;
  const std::vector<std::size_t> first = tasks_of(parts);
  std::vector<Moved> moved(first.size() - 1);
  tbb::parallel_for(std::size_t{0}, moved.size(), [&](std::size_t task) {
    for (std::size_t i = first[task]; i < first[task + 1] && !is_set(cancelled); ++i)
      Move(parts[i], static_cast<std::uint32_t>(i), moved[task]).copy();
  });
  auto made = std::make_unique<FlatTree>();
  Moved all;
  for (Moved& some : moved) {
    made->blocks_ += some.blocks;
    made->complete_ &= some.blocks == some.leaves.size();
    all.leaves.insert(all.leaves.end(), some.leaves.begin(), some.leaves.end());
    all.words.append(std::move(some.words));
    all.error = std::max(all.error, some.error);
  }
  if (made->blocks_ < least) return nullptr;
  double transforms = 0;
  for (const FlatPart& part : parts) {
    transforms = std::max(transforms, part.error);
    made->meshes_.push_back(part.placed);
  }
  for (const ClosedInstance& instance : closed) all.add_list(instance.id, instance.box);
  std::vector<Node> nodes;
  const Node* const root = blocks::join(all.leaves, nodes, cancelled);
  if (root == nullptr || is_set(cancelled)) return nullptr;
  made->frame_.bounds = root->box;
  made->frame_.error = geometry::round_up((all.error + transforms) * (1 + 0x1p-20));
  made->tree_ =
      std::make_unique<const WideTree>(*root, geometry::Vec3f{0, 0, 0}, std::move(all.words));

  const float size = largest_coordinate(made->frame_.bounds);
  if (!(size >= kLeastSize && size <= kLargestSize)) return nullptr;
  return made;
}

std::uint64_t FlatTree::bytes() const {
  return tree_->size_in_bytes() + meshes_.size() * sizeof(PlacedMesh);
}

}  // namespace sightline::accel::wide
