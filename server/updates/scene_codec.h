// Scenes and nodes between the wire and the scene graph.
#pragma once

#include "accel/result.h"
#include "scenegraph/revision/snapshot.h"
#include "server/scenes/revision_token.h"
#include "server/scenes/stored_scene.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server {

/// Checks the name and the recorded properties; output-only fields are ignored. Errors:
/// kInvalidArgument.
Result<SceneInfo> decode_scene(const v1::Scene& scene);

void encode_scene(const SceneInfo& info, const RevisionToken& head,
                  const scenegraph::SceneSummary& summary, v1::Scene& scene);
v1::Mobility encode_mobility(scenegraph::Mobility mobility);
void encode_node(const scenegraph::Node& node, v1::Node& out);
void encode_stats(const RevisionToken& revision, const scenegraph::BuildSummary& summary,
                  v1::GetSceneStatsResponse& reply);

}  // namespace sightline::server
