// A batch of updates as the update log keeps it.
#include "server/durable/batch_codec.h"

#include <cstddef>
#include <limits>
#include <utility>

#include "server/codec/update_codec.h"
#include "sightline/stored/v1/stored.pb.h"

namespace sightline::server::durable {

std::string encode_batch(const std::vector<scenegraph::model::Update>& updates,
                         const std::vector<scenegraph::model::NodeId>& nodes) {
  sightline::stored::v1::Batch batch;
  for (const scenegraph::model::Update& update : updates) {
    codec::encode_update(update, 0, std::numeric_limits<std::size_t>::max(), *batch.add_updates());
  }
  batch.mutable_nodes()->Assign(nodes.begin(), nodes.end());
  return batch.SerializeAsString();
}

Result<LoggedUpdates> decode_batch(std::string_view bytes, blobs::BlobStore& blobs) {
  sightline::stored::v1::Batch batch;
  if (!batch.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return Error{Code::kDataLoss, "it is no batch of updates", "STORE_CORRUPT"};
  auto updates = codec::decode_kept_updates(batch.updates(), blobs);
  if (!updates && updates.error().reason == "MESHES_MISSING")
    return Error{Code::kDataLoss, updates.error().message, "STORE_CORRUPT"};
  if (!updates) return updates.error();
  return LoggedUpdates{std::move(*updates), {batch.nodes().begin(), batch.nodes().end()}};
}

}  // namespace sightline::server::durable
