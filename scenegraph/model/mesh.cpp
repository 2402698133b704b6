// Checking a mesh's arrays, and reading them when they are needed.
#include "scenegraph/model/mesh.h"

#include <algorithm>
#include <utility>

#include <tbb/task_arena.h>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"

namespace sightline::scenegraph::model {
namespace {

Error bad_index(const accel::geometry::Face& face, std::size_t i, std::size_t vertices) {
  const std::uint32_t worst = *std::max_element(face.begin(), face.end());
  return {Code::kInvalidArgument,
          "face " + std::to_string(i) + " has vertex index " + std::to_string(worst) +
              ", but the mesh has " + std::to_string(vertices) + " vertices",
          "INDEX_OUT_OF_RANGE"};
}

/// A thread that waits for others in work() begins nothing of its arena meanwhile, such as a ray
/// that waits for a lock which this thread holds.
template <class Work>
auto isolated(const Work& work) -> decltype(work()) {
  return tbb::this_task_arena::isolate(work);
}

std::atomic<std::uint64_t>& dropped_trees() {
  static std::atomic<std::uint64_t> count{0};
  return count;
}

}  // namespace

struct Mesh::Tree final : OwnedTree, accel::kdtree::Retirable {
  explicit Tree(const Mesh& mesh)
      : OwnedTree(grown),
        grown(mesh.view(), mesh.survey_, mesh.builder_, mesh.references_, mesh.arrays_) {}

  accel::mesh::MeshTree grown;
};

Result<std::shared_ptr<const Mesh>> Mesh::make(std::vector<accel::geometry::Vec3f> vertices,
                                               std::vector<accel::geometry::Face> faces,
                                               const accel::mesh::TreeBuilder& builder,
                                               accel::mesh::References references) {
  if (faces.size() > kMaxFacesPerMesh) {
    return Error{Code::kResourceExhausted,
                 "the mesh has " + std::to_string(faces.size()) + " faces, the limit is " +
                     std::to_string(kMaxFacesPerMesh),
                 "MESH_TOO_LARGE"};
  }
  auto arrays = std::make_shared<const Arrays>(
      std::move(vertices),
      std::make_shared<const std::vector<accel::geometry::Face>>(std::move(faces)));
  const accel::geometry::MeshView view{arrays->vertices, *arrays->faces};
  const accel::mesh::MeshStats survey = accel::mesh::compute_mesh_stats(view);
  if (const std::size_t bad = survey.first_bad_face; bad < view.faces.size())
    return bad_index(view.faces[bad], bad, view.vertices.size());
  return std::shared_ptr<const Mesh>(
      new Mesh(std::move(arrays), survey, builder, references, nullptr));
}

Mesh::Mesh(std::shared_ptr<const Arrays> arrays, const accel::mesh::MeshStats& survey,
           const accel::mesh::TreeBuilder& builder, accel::mesh::References references,
           std::shared_ptr<const void> charge)
    : charge_(std::move(charge)),
      arrays_(std::move(arrays)),
      vertices_(arrays_->vertices.size()),
      faces_(arrays_->faces->size()),
      survey_(survey),
      builder_(builder),
      references_(references),
      tree_(new Tree(*this)) {}

Mesh::Mesh(const Mesh& surveyed, std::unique_ptr<const MeshSource> source)
    : unread_(new Unread{std::move(source), {}}),
      vertices_(surveyed.vertices_),
      faces_(surveyed.faces_),
      survey_(surveyed.survey_),
      builder_(surveyed.builder_),
      references_(surveyed.references_),
      tree_(nullptr) {}

Mesh::~Mesh() {
  if (OwnedTree* const tree = tree_.load(std::memory_order_acquire)) tree->leave();
}

std::shared_ptr<const Mesh> Mesh::unread(std::unique_ptr<const MeshSource> source) const {
  return std::shared_ptr<const Mesh>(new Mesh(*this, std::move(source)));
}

Status Mesh::make_resident(Reclaim reclaim) const {
  if (is_resident()) return {};
  // The lock is not held here: reclaiming memory takes locks that threads which wait for this one
  // may hold.
  auto charge = unread_->source->charge(bytes(), reclaim);
  if (!charge) return charge.error();
  const std::lock_guard lock(unread_->reading);
  if (is_resident()) return {};
  const auto read = isolated([&] { return unread_->source->read(); });
  if (!read) return read.error();
  charge_ = std::move(*charge);
  arrays_ = (*read)->arrays_;
  tree_.store(new Tree(*this), std::memory_order_release);
  return {};
}

void Mesh::with_arrays(const std::function<void(const accel::geometry::MeshView&)>& use) const {
  if (is_resident()) return use(view());
  const auto charge = unread_->source->charge(bytes(), Reclaim::kAllowed);
  if (!charge) throw MeshUnreadable(charge.error());
  const auto read = isolated([&] { return unread_->source->read(); });
  if (!read) throw MeshUnreadable(read.error());
  use((*read)->view());
}

Mesh::OwnedTree& Mesh::read_tree() const {
  if (const Status resident = make_resident(Reclaim::kAllowed); !resident)
    throw MeshUnreadable(resident.error());
  return *tree_.load(std::memory_order_acquire);
}

Result<std::shared_ptr<const Mesh>> Mesh::deformed(std::vector<accel::geometry::Vec3f> vertices,
                                                   std::shared_ptr<const void> charge) const {
  if (vertices.size() != vertices_) {
    return Error{Code::kInvalidArgument,
                 std::to_string(vertices.size()) + " vertices, but the mesh has " +
                     std::to_string(vertices_),
                 "COUNT_MISMATCH"};
  }
  if (const Status resident = make_resident(Reclaim::kForbidden); !resident)
    return resident.error();
  auto arrays = std::make_shared<const Arrays>(std::move(vertices), arrays_->faces);
  const accel::mesh::MeshStats survey = isolated([&] {
    return accel::mesh::compute_mesh_stats({arrays->vertices, *arrays->faces});
  });
  return std::shared_ptr<const Mesh>(
      new Mesh(std::move(arrays), survey, builder_, references_, std::move(charge)));
}

std::uint64_t Mesh::bytes_deformed() const {
  return sizeof(Mesh) + sizeof(Tree) + sizeof(Arrays) + vertices_ * sizeof(accel::geometry::Vec3f);
}

std::uint64_t Mesh::tree_bytes() const {
  if (!is_resident()) return 0;
  const accel::kdtree::EpochPin pin;
  return tree().bytes();
}

std::uint64_t Mesh::drop_tree() const {
  if (!is_resident()) return 0;
  const accel::kdtree::EpochPin pin;
  if (tree().untouched()) return 0;
  auto* const old = static_cast<Tree*>(tree_.exchange(new Tree(*this), std::memory_order_acq_rel));
  count_dropped();
  const std::uint64_t bytes = old->tree.bytes();
  accel::kdtree::retire(
      *old, [](accel::kdtree::Retirable* tree) { static_cast<Tree*>(tree)->leave(); }, bytes);
  return bytes;
}

std::uint64_t Mesh::trees_dropped() { return dropped_trees().load(std::memory_order_acquire); }

void Mesh::count_dropped() { dropped_trees().fetch_add(1, std::memory_order_release); }

std::uint64_t Mesh::bytes() const {
  return vertices_ * sizeof(accel::geometry::Vec3f) + faces_ * sizeof(accel::geometry::Face);
}

}  // namespace sightline::scenegraph::model
