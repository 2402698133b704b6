// Copies a range of a blob out of a mesh's arrays.
#include "server/updates/mesh_reader.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "server/blobs/blob_rpc.h"
#include "server/blobs/mesh_blob.h"
#include "server/updates/scene_codec.h"

namespace sightline::server::updates {
namespace {

using SnapshotPointer = std::shared_ptr<const scenegraph::revision::Snapshot>;

Result<SnapshotPointer> snapshot_of(const scenes::StoredScene& scene,
                                    const v1::ReadMeshRequest& request) {
  if (request.has_revision()) return scene.at(request.revision());
  return scene.snapshot();
}

/// Sets the size of the whole blob, and the bytes from `offset` on that a message may have.
Status copy_part(const scenegraph::model::Mesh& mesh, std::uint64_t offset,
                 v1::ReadMeshResponse& reply) {
  std::uint64_t size = 0;  // bytes of the pieces so far
  return blobs::write_mesh_blob(mesh, [&](std::span<const std::byte> piece) -> Status {
    const std::uint64_t begin =
        std::min<std::uint64_t>(std::max(offset, size) - size, piece.size());
    const std::size_t capacity = blobs::kMaxBlobChunk - reply.data().size();
    const auto part = piece.subspan(begin, std::min<std::uint64_t>(capacity, piece.size() - begin));
    reply.mutable_data()->append(reinterpret_cast<const char*>(part.data()), part.size());
    size += piece.size();
    reply.set_size(size);
    return {};
  });
}

}  // namespace

Status read_mesh(const scenes::Services& services, const v1::ReadMeshRequest& request,
                 v1::ReadMeshResponse& reply) {
  const auto scene = services.find_loaded(request.scene());
  if (!scene) return scene.error();
  const auto snapshot = snapshot_of(**scene, request);
  if (!snapshot) return snapshot.error();
  const scenegraph::model::Node* const node = (*snapshot)->find(request.node());
  if (node == nullptr) {
    return Error{Code::kNotFound, "there is no node " + std::to_string(request.node()),
                 "NODE_NOT_FOUND"};
  }
  if (node->mesh == nullptr) {
    return Error{Code::kFailedPrecondition, described(*node) + " has no mesh", "NODE_WITHOUT_MESH"};
  }
  encode_revision((*scene)->token((*snapshot)->revision()), *reply.mutable_served());
  return copy_part(*node->mesh, request.offset(), reply);
}

}  // namespace sightline::server::updates
