// The rows of a scene that is restored: it counts as removed until it takes the place of another.
#pragma once

#include <cstdint>
#include <span>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/snapshot_rows.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Makes the rows: that of the scene, and that of its base, which is being written and which is
/// returned. If the process dies, they are garbage: see abandon_unfinished(). Errors: as Database.
Result<SnapshotRow> begin_restored(Database& database, const SceneInfo& info,
                                   std::uint64_t revision,
                                   std::span<const blobs::BlobDigest> blobs);
/// Publishes this scene after its snapshot is written. The one of its name, if there is one, is
/// removed, or is the error if it may not be replaced. Errors: as Database, kAlreadyExists.
Status publish_restored(Database& database, SnapshotRow base, std::uint64_t chunks, bool replace);

}  // namespace sightline::server::store
