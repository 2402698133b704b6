// Checking a mesh's arrays.
#include "scenegraph/model/mesh.h"

#include <algorithm>
#include <utility>

namespace sightline::scenegraph::model {
namespace {

Error bad_index(const accel::geometry::Face& face, std::size_t i, std::size_t vertices) {
  const std::uint32_t worst = *std::max_element(face.begin(), face.end());
  return {Code::kInvalidArgument,
          "face " + std::to_string(i) + " has vertex index " + std::to_string(worst) +
              ", but the mesh has " + std::to_string(vertices) + " vertices",
          "INDEX_OUT_OF_RANGE"};
}

std::atomic<std::uint64_t>& dropped_trees() {
  static std::atomic<std::uint64_t> count{0};
  return count;
}

}  // namespace

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

Mesh::Tree::Tree(const Mesh& mesh)
    : tree(mesh.view(), mesh.survey_, mesh.builder_, mesh.references_, mesh.arrays_) {}

Mesh::Mesh(std::shared_ptr<const Arrays> arrays, const accel::mesh::MeshStats& survey,
           const accel::mesh::TreeBuilder& builder, accel::mesh::References references,
           std::shared_ptr<const void> charge)
    : charge_(std::move(charge)),
      arrays_(std::move(arrays)),
      survey_(survey),
      builder_(builder),
      references_(references),
      tree_(new Tree(*this)) {}

Mesh::~Mesh() { tree_.load(std::memory_order_acquire)->leave(); }

Result<std::shared_ptr<const Mesh>> Mesh::deformed(std::vector<accel::geometry::Vec3f> vertices,
                                                   std::shared_ptr<const void> charge) const {
  if (vertices.size() != arrays_->vertices.size()) {
    return Error{Code::kInvalidArgument,
                 std::to_string(vertices.size()) + " vertices, but the mesh has " +
                     std::to_string(arrays_->vertices.size()),
                 "COUNT_MISMATCH"};
  }
  auto arrays = std::make_shared<const Arrays>(std::move(vertices), arrays_->faces);
  const accel::mesh::MeshStats survey =
      accel::mesh::compute_mesh_stats({arrays->vertices, *arrays->faces});
  return std::shared_ptr<const Mesh>(
      new Mesh(std::move(arrays), survey, builder_, references_, std::move(charge)));
}

std::uint64_t Mesh::bytes_deformed() const {
  return sizeof(Mesh) + sizeof(Tree) + sizeof(Arrays) +
         arrays_->vertices.size() * sizeof(accel::geometry::Vec3f);
}

std::uint64_t Mesh::tree_bytes() const {
  const accel::kdtree::EpochPin pin;
  return tree().bytes();
}

std::uint64_t Mesh::drop_tree() const {
  const accel::kdtree::EpochPin pin;
  if (tree().untouched()) return 0;
  Tree* const old = tree_.exchange(new Tree(*this), std::memory_order_acq_rel);
  count_dropped();
  const std::uint64_t bytes = old->tree.bytes();
  accel::kdtree::retire(
      *old, [](accel::kdtree::Retirable* tree) { static_cast<Tree*>(tree)->leave(); }, bytes);
  return bytes;
}

std::uint64_t Mesh::trees_dropped() { return dropped_trees().load(std::memory_order_acquire); }

void Mesh::count_dropped() { dropped_trees().fetch_add(1, std::memory_order_release); }

std::uint64_t Mesh::bytes() const {
  return arrays_->vertices.size() * sizeof(accel::geometry::Vec3f) +
         arrays_->faces->size() * sizeof(accel::geometry::Face);
}

}  // namespace sightline::scenegraph::model
