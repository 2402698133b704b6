// Decodes and encodes scenes.
#pragma once

#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "server/scenes/names.h"
#include "server/scenes/stored_scene.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

/// Checks the name and the recorded properties; output-only fields are ignored. Errors:
/// kInvalidArgument.
Result<scenes::SceneInfo> decode_scene(const v1::Scene& scene);

/// Sets what the scene was created with.
void encode_info(const scenes::SceneInfo& info, v1::Scene& scene);
/// Sets what encode_info() sets, and the head and the summary.
void encode_scene(const scenes::SceneInfo& info, const scenes::RevisionToken& head,
                  const scenegraph::revision::SceneSummary& summary, v1::Scene& scene);
void encode_stats(const scenes::RevisionToken& revision,
                  const scenegraph::revision::BuildSummary& summary,
                  v1::GetSceneStatsResponse& reply);

}  // namespace sightline::server::updates
