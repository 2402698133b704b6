// Lists the pieces of all trees, sorts them, and evicts the first ones.
#include "scenegraph/model/eviction.h"

#include <algorithm>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/eviction.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/mesh_tree.h"

namespace sightline::scenegraph::model {
namespace {

using accel::kdtree::EpochPin;
using accel::kdtree::TreeBytes;
using accel::kdtree::TreeMemory;

struct Leave {
  void operator()(accel::kdtree::RefCounted* owner) const { owner->leave(); }
};

/// A tree, kept alive: its mesh may begin another one meanwhile.
struct HeldTree {
  std::unique_ptr<accel::kdtree::RefCounted, Leave> owner;
  accel::lazy::LazyTree* tree;
};

struct Piece {
  HeldTree* of;
  accel::lazy::Evictable what;
};

std::vector<HeldTree> hold(std::span<const std::shared_ptr<const Mesh>> meshes) {
  std::vector<HeldTree> trees;
  trees.reserve(meshes.size());
  for (const auto& mesh : meshes) {
    if (!mesh->is_resident()) continue;
    const EpochPin pin;
    Mesh::OwnedTree& now = mesh->owned_tree();
    accel::lazy::LazyTree* const tree = now.tree.lazy_tree();
    if (tree == nullptr) continue;
    now.join();
    trees.push_back({decltype(HeldTree::owner)(&now), tree});
  }
  return trees;
}

std::vector<Piece> list_pieces(std::vector<HeldTree>& trees) {
  std::vector<Piece> pieces;
  std::vector<accel::lazy::Evictable> found;
  for (HeldTree& tree : trees) {
    found.clear();
    const EpochPin pin;
    tree.tree->list_evictable(found);
    for (const accel::lazy::Evictable& what : found) pieces.push_back({&tree, what});
  }
  return pieces;
}

/// What will be held once all that is retired is freed.
std::uint64_t kept(const TreeMemory& memory) {
  const std::uint64_t held = memory.held();
  return held - std::min(held, memory.held(TreeBytes::kRetired));
}

}  // namespace

std::uint64_t evict(std::span<const std::shared_ptr<const Mesh>> meshes, TreeMemory& memory,
                    std::uint64_t goal) {
  accel::kdtree::reclaim();
  if (kept(memory) <= goal) return 0;
  std::vector<HeldTree> trees = hold(meshes);
  std::vector<Piece> pieces = list_pieces(trees);
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const Piece& a, const Piece& b) { return a.what.value < b.what.value; });
  std::uint64_t evicted = 0;
  for (const Piece& piece : pieces) {
    if (kept(memory) <= goal) break;
    const EpochPin pin;
    const std::uint64_t bytes = piece.of->tree->evict(piece.what);
    if (bytes == 0) continue;
    memory.count_eviction(bytes);
    evicted += bytes;
  }
  if (evicted > 0) Mesh::count_dropped();
  accel::kdtree::reclaim();
  return evicted;
}

}  // namespace sightline::scenegraph::model
