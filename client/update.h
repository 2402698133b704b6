// What can be done to a scene's nodes.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/types.h"

namespace sightline::client {

/// A node's id (> 0), the negative alias that an earlier PutNode of the same batch gave it, or 0:
/// none.
using NodeRef = std::int64_t;

/// Creates a node (`node` is a fresh negative alias) or replaces all that is said of one (its id).
struct PutNode {
  NodeRef node = 0;
  NodeRef parent = 0;  ///< 0: a root.
  std::string name;    ///< UTF-8.
  Transform parent_from_local = kIdentity;
  std::string mesh_digest;  ///< Of an uploaded mesh. Empty: a group.
  Mobility mobility = Mobility::kStatic;
  std::uint32_t mask = 0xffffffff;
};

struct SetTransforms {
  std::vector<NodeRef> nodes;
  std::vector<Transform> parent_from_local;  ///< As many as nodes.
};

struct DeleteNode {
  NodeRef node = 0;
  bool subtree = false;  ///< Needed if the node has children.
};

/// New places for some vertices of a mesh; its faces stay. The nodes must carry one and the same
/// mesh, and share the new one; others that carry the old one keep it.
struct PatchVertices {
  std::vector<NodeRef> nodes;
  std::uint32_t first = 0;        ///< The first vertex that changes.
  std::vector<Vertex> positions;  ///< In the mesh's frame.
};

using Update = std::variant<PutNode, SetTransforms, DeleteNode, PatchVertices>;

struct Applied {
  std::uint64_t revision = 0;
  std::vector<std::uint64_t> nodes;  ///< The id of every PutNode's node, in order.
  std::string token;                 ///< Of the revision, for Consistency::at_least.
  bool replayed = false;             ///< Applied before, by a request of the same id.
};

struct ApplyOptions {
  /// Refused (kAborted) unless this is the scene's revision.
  std::optional<std::uint64_t> expected_revision{};
  /// Names the request, at most 48 bytes: one that is repeated changes nothing and gets the first
  /// answer. Empty: a random one. Either way a request whose answer is lost is sent again.
  std::string request_id{};
};

struct SceneChange {
  std::uint64_t revision = 0;
  std::string token;  ///< Of the revision, for Consistency::at_least.
  /// The updates that made the revision. They name nodes by id, also those that were put new.
  std::vector<Update> updates;
  /// Nothing changed: the message only says that this revision has been reached. One comes at the
  /// start, and then one every few seconds.
  bool is_progress = false;
};

/// Takes the revisions in order and without gaps, on the thread that watches. Returning false ends
/// the watch.
using SceneChangeSink = std::function<bool(const SceneChange& change)>;

}  // namespace sightline::client
