// Scenes, nodes and updates between the wire and the scene graph.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "accel/result.h"
#include "scenegraph/snapshot.h"
#include "scenegraph/update.h"
#include "server/blob_store.h"
#include "server/stored_scene.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server {

inline constexpr int kMaxUpdatesPerBatch = 65536;

/// Checks the name and the recorded properties; output-only fields are ignored. Errors:
/// kInvalidArgument.
Result<SceneInfo> decode_scene(const v1::Scene& scene);

/// Looks every mesh up by its digest.
/// Errors name the update's place in the batch: kInvalidArgument (an empty update, not 12 numbers
/// to a matrix, an unknown mobility, a bad digest), kFailedPrecondition (listing the digests that
/// are missing), kResourceExhausted over kMaxUpdatesPerBatch. What only the scene can know is left
/// to Scene::apply.
Result<std::vector<scenegraph::Update>> decode_updates(const v1::ApplyUpdatesRequest& request,
                                                       const BlobStore& blobs);

void encode_scene(const SceneInfo& info, const scenegraph::SceneSummary& summary, v1::Scene& scene);
void encode_node(const scenegraph::Node& node, v1::Node& out);
void encode_stats(std::uint64_t revision, const scenegraph::BuildSummary& summary,
                  v1::GetSceneStatsResponse& reply);

}  // namespace sightline::server
