// Changes to a scene's nodes, and the reports of single requests, watches and streams of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "client/node_ref.h"
#include "client/result.h"
#include "client/types.h"

namespace sightline::client {

/// Creates a node (`node` is a new negative alias), or replaces all attributes of a node (`node` is
/// its id).
struct PutNode {
  NodeRef node = 0;
  NodeRef parent = 0;  ///< 0: a root
  std::string name{};  ///< UTF-8
  Transform parent_from_local = kIdentity;
  std::string mesh_digest{};  ///< an uploaded mesh's; empty: a group
  Mobility mobility = Mobility::kStatic;
  std::uint32_t mask = 0xffffffff;
  std::vector<Label> labels{};
};

struct SetTransforms {
  NodeRefs nodes;
  std::vector<Transform> parent_from_local;  ///< one per node
};

struct DeleteNode {
  NodeRef node = 0;
  bool subtree = false;  ///< required if the node has children
};

/// New positions for some vertices of a mesh; its faces stay. The nodes must have the same mesh.
/// They share the new mesh; other nodes keep the old one.
struct PatchVertices {
  NodeRefs nodes;
  std::uint32_t first = 0;        ///< the first vertex that changes
  std::vector<Vertex> positions;  ///< in the mesh's frame
};

using Update = std::variant<PutNode, SetTransforms, DeleteNode, PatchVertices>;

struct Applied {
  std::uint64_t revision = 0;
  std::vector<std::uint64_t> nodes;  ///< the id of every PutNode's node, in order
  std::string token;                 ///< the revision's, for Consistency::at_least
  bool replayed = false;             ///< applied before, by a request of the same id
};

struct ApplyOptions {
  /// The updates are refused (kAborted) unless this is the scene's revision.
  std::optional<std::uint64_t> expected_revision{};
  /// Names the request, at most 48 bytes. A repeated request changes nothing and gets the first
  /// answer. Empty: a random name. In both cases a request whose answer is lost is sent again.
  std::string request_id{};
  /// Ends the call with kCancelled. The updates may be applied nevertheless: repeat the request by
  /// its id, or read the scene's revision. With a cast that has a stop of its own, that one counts.
  std::stop_token stop{};
};

struct PutSceneOptions {
  UpAxis up_axis = UpAxis::kUnknown;
  double meters_per_unit = 0;  ///< 0: unknown
  bool replace = false;        ///< takes the place of a scene of that name, if there is one
  std::stop_token stop{};      ///< ends the call with kCancelled
};

struct SceneChange {
  std::uint64_t revision = 0;
  std::string token;  ///< the revision's, for Consistency::at_least
  /// The updates that made the revision. They name nodes by id, also those that were put new.
  std::vector<Update> updates;
  /// Nothing changed: the message only says that this revision has been reached. One comes at the
  /// start, and then one every few seconds.
  bool is_progress = false;
};

/// Takes the revisions in order and without gaps, on the thread that watches. Returning false ends
/// the watch.
using SceneChangeSink = std::function<bool(const SceneChange& change)>;

/// All batches up to a sequence number are answered: applied or rejected.
struct StreamAck {
  struct Put {
    std::uint64_t sequence = 0;
    std::vector<std::uint64_t> nodes;  ///< the id of every PutNode's node of that batch, in order
  };
  std::uint64_t up_to_sequence = 0;
  std::uint64_t revision = 0;  ///< contains all of them
  std::string token;           ///< the revision's, for Consistency::at_least
  std::vector<Put> put;        ///< batches answered since the previous ack
};

/// One batch was rejected and had no effect. All batches before it are answered, and the stream
/// continues.
struct StreamReject {
  std::uint64_t sequence = 0;
  Error error;
};

struct UpdateStreamOptions {
  /// The server may merge waiting batches: for each node, only the newest transform and the newest
  /// vertices count. A batch with any other update is applied as it is.
  bool latest_wins = false;
  /// The server may acknowledge batches before they are on disk. If it dies, it may lose the last
  /// of them, and the stream ends with kAborted.
  bool relaxed = false;
  /// How many times in a row the call is opened before a broken connection becomes an error.
  int attempts = 8;
  /// Called in the order of answers, on a thread of the stream, which continues after they return.
  /// They must not call send, wait, flush or close, and must not destroy the stream.
  std::function<void(const StreamAck&)> on_ack{};
  std::function<void(const StreamReject&)> on_reject{};
};

struct UpdateStreamState {
  std::uint64_t last_sent = 0;      ///< sequence numbers; they continue those of earlier
  std::uint64_t last_answered = 0;  ///< streams of the same producer
  std::uint64_t revision = 0;       ///< contains all that is answered
  std::string token;
  std::uint32_t window = 0;     ///< how many batches may be unanswered
  std::uint64_t coalesced = 0;  ///< batches that were replaced by newer ones
  std::uint64_t rejected = 0;
  std::uint64_t reconnects = 0;
  std::uint64_t bytes_sent = 0;  ///< bytes of messages, including those sent again
};

}  // namespace sightline::client
