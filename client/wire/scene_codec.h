// Scenes, nodes and the server's facts, from messages. Internal to the library.
#pragma once

#include "client/scene_info.h"
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

}  // namespace sightline::client::wire
