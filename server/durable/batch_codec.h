// A batch of updates as the update log keeps it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "server/blobs/blob_store.h"

namespace sightline::server::durable {

/// A batch with the ids of the nodes that it puts, in order.
struct LoggedUpdates {
  std::vector<scenegraph::model::Update> updates;
  std::vector<scenegraph::model::NodeId> nodes;
};

/// `updates`: as given to Scene::apply.
std::string encode_batch(const std::vector<scenegraph::model::Update>& updates,
                         const std::vector<scenegraph::model::NodeId>& nodes);

/// Meshes come from `blobs`. Errors: kDataLoss (encode_batch() has not made it), as
/// BlobStore::load.
Result<LoggedUpdates> decode_batch(std::string_view bytes, blobs::BlobStore& blobs);

}  // namespace sightline::server::durable
