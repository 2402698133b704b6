// Scenes, nodes, updates and facts about the server, to and from messages. Internal to the library.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <unordered_map>

#include "client/result.h"
#include "client/scene_info.h"
#include "client/types.h"
#include "client/update.h"
#include "sightline/v1/scene.pb.h"
#include "sightline/v1/server.pb.h"

namespace sightline::client::wire {

namespace v1 = ::sightline::v1;

v1::UpAxis encode(UpAxis axis);
v1::Mobility encode(Mobility mobility);
v1::Transform encode(const Transform& transform);

Mobility decode(v1::Mobility mobility);
SceneInfo decode(const v1::Scene& scene);
SceneStats decode(const v1::GetSceneStatsResponse& stats);
NodeInfo decode(const v1::Node& node);
ServerInfo decode(const v1::GetServerInfoResponse& info);

namespace v1 = ::sightline::v1;

/// The size limit for all updates of one message: the message's limit without the envelope.
inline constexpr std::size_t kMaxUpdateBytes = (std::size_t{1} << 20) - 4096;

/// Ids of the nodes that earlier messages created, by alias.
class NodeAliases {
 public:
  NodeRef resolve(NodeRef ref) const {
    const auto found = ids_.find(ref);
    return found == ids_.end() ? ref : NodeRef(found->second);
  }
  void add(NodeRef alias, std::uint64_t id) { ids_.emplace(alias, id); }

 private:
  std::unordered_map<NodeRef, std::uint64_t> ids_;
};

v1::Update encode(const Update& update, const NodeAliases& aliases = {});

/// Errors: kInternal: a kind of update that this library does not know, or a column of a wrong
/// length.
Result<Update> decode(const v1::Update& update);

v1::Consistency encode(const Consistency& consistency);

/// Errors: kInvalidArgument, naming the update: the numbers of nodes and transforms differ.
Status check(std::span<const Update> updates);

/// Splits an update that is too long for a message into several with the same effect. Other updates
/// are passed on unchanged.
Status each_piece(const Update& update, const std::function<Status(const Update&)>& use);

}  // namespace sightline::client::wire
