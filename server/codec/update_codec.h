// Decodes and encodes updates.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <cstddef>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "server/blobs/blob_store.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::codec {

inline constexpr int kMaxUpdatesPerBatch = 65536;
inline constexpr int kMaxNodesPerPatch = 65536;

/// Errors: kResourceExhausted over kMaxUpdatesPerBatch.
Status check_update_count(std::size_t count);

/// Decodes updates and finds every mesh by its digest. `first` is the index of the first update in
/// its batch. Errors name the update's index in the batch: kInvalidArgument (an empty update, a
/// matrix without 12 numbers, columns of different lengths, an unknown mobility, a bad digest, too
/// many nodes in a patch), kFailedPrecondition (listing the digests that are missing),
/// kResourceExhausted over kMaxUpdatesPerBatch, as BlobStore::load. Scene::apply checks what
/// depends on the scene.
Result<std::vector<scenegraph::model::Update>> decode_updates(
    const google::protobuf::RepeatedPtrField<v1::Update>& updates, blobs::BlobStore& blobs,
    std::size_t first = 0);

/// Decodes nodes that are put. `first` is the number of nodes before them; the limit is that of one
/// message. Errors: as decode_updates().
Result<std::vector<scenegraph::model::Update>> decode_nodes(
    const google::protobuf::RepeatedPtrField<v1::PutNode>& nodes, blobs::BlobStore& blobs,
    std::size_t first);

/// Decodes what encode_update() has made of a batch of any length. Errors: as decode_updates().
Result<std::vector<scenegraph::model::Update>> decode_kept_updates(
    const google::protobuf::RepeatedPtrField<v1::Update>& updates, blobs::BlobStore& blobs);

/// Encodes part of an update: from row `first` of its columns, as many rows as fit `bytes`, and at
/// least one. An update without columns is encoded completely. Returns the next row, or 0 after the
/// last.
std::size_t encode_update(const scenegraph::model::Update& update, std::size_t first,
                          std::size_t bytes, v1::Update& out);

}  // namespace sightline::server::codec
