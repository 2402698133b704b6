// All nodes of a scene at one revision, as snapshots keep them.
#include "server/durable/nodes_codec.h"

#include <algorithm>
#include <utility>

#include "server/codec/node_codec.h"

namespace sightline::server::durable {
namespace {

using sightline::stored::v1::NodesPart;
using sightline::stored::v1::StoredNode;

Error corrupt(const std::string& why) {
  return {Code::kDataLoss, "the stored nodes are corrupt: " + why, "STORE_CORRUPT"};
}

void push_reversed(const scenegraph::model::ChildList& children,
                   std::vector<scenegraph::model::NodeId>& ids) {
  const std::size_t first = ids.size();
  ids.insert(ids.end(), children.begin(), children.end());
  std::reverse(ids.begin() + static_cast<std::ptrdiff_t>(first), ids.end());
}

}  // namespace

NodesWriter::NodesWriter(const scenegraph::SceneState& state) : state_(state) {
  state_.snapshot->nodes().for_each(
      [this](scenegraph::model::NodeId, const auto& node) { add_mesh(*node); });
  push_reversed(state_.snapshot->roots(), ahead_);
}

void NodesWriter::add_mesh(const scenegraph::model::Node& node) {
  if (node.mesh == nullptr) return;
  const auto number = static_cast<std::uint32_t>(meshes_.size() + 1);
  if (!numbers_.emplace(node.mesh.get(), number).second) return;
  if (node.patched) patched_.push_back({node.mesh.get(), {}});
  meshes_.push_back({node.mesh_digest, node.patched ? patched_.size() : 0});
}

Result<std::uint64_t> NodesWriter::keep_patched(blobs::BlobStore& blobs) {
  std::uint64_t bytes = 0;
  for (Patched& patched : patched_) {
    const auto digest = blobs.keep(*patched.mesh);
    if (!digest) return digest.error();
    patched.digest = *digest;
    bytes += digest->size;
  }
  return bytes;
}

std::vector<blobs::BlobDigest> NodesWriter::blobs() const {
  std::vector<blobs::BlobDigest> digests;
  for (const Listed& mesh : meshes_) {
    // A node without a digest was put by a test or by no client; its mesh cannot be stored.
    if (const auto digest = blobs::BlobDigest::parse(mesh.digest)) digests.push_back(*digest);
  }
  for (const Patched& mesh : patched_) digests.push_back(mesh.digest);
  std::ranges::sort(digests);
  const auto repeated = std::ranges::unique(digests);
  digests.erase(repeated.begin(), repeated.end());
  return digests;
}

void NodesWriter::list_mesh(const Listed& mesh, NodesPart& part) const {
  sightline::stored::v1::Mesh& listed = *part.add_meshes();
  listed.set_digest(mesh.digest);
  if (mesh.patched > 0) listed.set_patched(patched_[mesh.patched - 1].digest.text());
}

void NodesWriter::write_node(const scenegraph::model::Node& node, StoredNode& stored) const {
  codec::encode_node(node, *stored.mutable_node());
  stored.mutable_node()->clear_mesh_digest();
  stored.mutable_node()->clear_patched();
  if (node.mesh != nullptr) stored.set_mesh(numbers_.at(node.mesh.get()));
}

std::string NodesWriter::next(std::size_t bytes) {
  if (begun_ && listed_ == meshes_.size() && ahead_.empty()) return {};
  NodesPart part;
  if (!std::exchange(begun_, true)) part.set_next_id(state_.next_id);
  std::size_t taken = 0;
  for (; taken < bytes && listed_ < meshes_.size(); ++listed_) {
    list_mesh(meshes_[listed_], part);
    taken += part.meshes(part.meshes_size() - 1).ByteSizeLong();
  }
  while (taken < bytes && !ahead_.empty()) {
    const scenegraph::model::Node& node = *state_.snapshot->find(ahead_.back());
    ahead_.pop_back();
    push_reversed(node.children, ahead_);
    StoredNode& stored = *part.add_nodes();
    write_node(node, stored);
    taken += stored.ByteSizeLong();
  }
  return part.SerializeAsString();
}

Status NodesReader::add(std::string_view bytes) {
  NodesPart part;
  if (!part.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return corrupt("a part is none");
  if (part.next_id() != 0) content_.next_id = part.next_id();
  for (const auto& mesh : part.meshes()) {
    if (Status added = add_mesh(mesh); !added) return added;
  }
  for (const auto& node : part.nodes()) {
    if (Status added = add_node(node); !added) return added;
  }
  return {};
}

Status NodesReader::add_mesh(const sightline::stored::v1::Mesh& mesh) {
  const bool patched = !mesh.patched().empty();
  const auto digest = blobs::BlobDigest::parse(mesh.digest());
  if (!digest) return corrupt(digest.error().message);
  auto loaded = blobs_.use(*digest);
  if (patched && loaded) {
    const auto vertices = blobs::BlobDigest::parse(mesh.patched());
    if (!vertices) return corrupt(vertices.error().message);
    loaded = blobs_.load_patched(**loaded, *vertices);
  }
  if (!loaded) return loaded.error();
  meshes_.push_back({std::move(*loaded), mesh.digest(), patched});
  return {};
}

Status NodesReader::add_node(const sightline::stored::v1::StoredNode& stored) {
  auto node = codec::decode_node(stored.node());
  if (!node) return corrupt(node.error().message);
  if (stored.mesh() > meshes_.size()) return corrupt("a node has a mesh that is not listed");
  if (stored.mesh() > 0) {
    const Listed& mesh = meshes_[stored.mesh() - 1];
    node->mesh = mesh.mesh;
    node->mesh_digest = mesh.digest;
    node->patched = mesh.patched;
  }
  content_.nodes.push_back(std::move(*node));
  return {};
}

scenegraph::SceneContent NodesReader::finish(std::uint64_t revision) && {
  content_.revision = revision;
  return std::move(content_);
}

}  // namespace sightline::server::durable
