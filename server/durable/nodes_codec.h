// All nodes of a scene at one revision, as snapshots keep them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "proto/result.h"
#include "scenegraph/scene.h"
#include "server/blobs/blob_store.h"
#include "sightline/stored/v1/stored.pb.h"

namespace sightline::server::durable {

/// About the bytes of a part.
inline constexpr std::size_t kPartBytes = std::size_t{1} << 20;

/// Writes a revision in parts. Threads: one at a time.
class NodesWriter {
 public:
  /// Numbers the meshes. Cost: one walk of the scene.
  explicit NodesWriter(const scenegraph::SceneState& state);

  /// Makes blobs of the meshes whose vertices were changed. Call it first. Waits for the disk.
  /// Returns their bytes. Errors: as BlobStore::keep.
  Result<std::uint64_t> keep_patched(blobs::BlobStore& blobs);
  /// The names of all blobs that the parts name.
  std::vector<blobs::BlobDigest> blobs() const;

  /// The next part, of about `bytes` bytes; empty after the last.
  std::string next(std::size_t bytes);

 private:
  /// A mesh whose vertices were changed, and the blob that has them.
  struct Patched {
    const scenegraph::model::Mesh* mesh = nullptr;
    blobs::BlobDigest digest;
  };
  struct Listed {
    std::string digest;
    std::size_t patched = 0;  ///< Index in patched_, plus 1; 0: not patched.
  };
  void add_mesh(const scenegraph::model::Node& node);
  void write_node(const scenegraph::model::Node& node,
                  sightline::stored::v1::StoredNode& stored) const;
  void list_mesh(const Listed& mesh, sightline::stored::v1::NodesPart& part) const;

  const scenegraph::SceneState state_;
  std::vector<Listed> meshes_;
  std::vector<Patched> patched_;
  std::unordered_map<const scenegraph::model::Mesh*, std::uint32_t> numbers_;  // from 1
  std::vector<scenegraph::model::NodeId> ahead_;  // nodes to write, the next one last
  std::size_t listed_ = 0;                        // meshes that parts have listed
  bool begun_ = false;
};

/// Puts the parts together again. Threads: one at a time.
class NodesReader {
 public:
  explicit NodesReader(blobs::BlobStore& blobs) : blobs_(blobs) {}

  /// Errors: kDataLoss (NodesWriter has not made it), as BlobStore::load.
  Status add(std::string_view part);
  /// Nodes so far.
  std::size_t size() const { return content_.nodes.size(); }
  /// The nodes of all parts. Call it after the last part.
  scenegraph::SceneContent finish(std::uint64_t revision) &&;

 private:
  Status add_mesh(const sightline::stored::v1::Mesh& mesh);
  Status add_node(const sightline::stored::v1::StoredNode& stored);

  struct Listed {
    std::shared_ptr<const scenegraph::model::Mesh> mesh;
    std::string digest;
    bool patched = false;
  };
  blobs::BlobStore& blobs_;
  std::vector<Listed> meshes_;
  scenegraph::SceneContent content_;
};

}  // namespace sightline::server::durable
