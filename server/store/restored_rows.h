// The rows of a scene that is restored: it counts as removed until it takes the place of another.
#pragma once

#include <cstdint>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/store.h"

namespace sightline::server::store {

struct RestoredScene {
  SceneId scene = 0;
  std::int64_t snapshot = 0;  ///< Its base, which is being written.
};

/// Makes the rows. If the process dies, they are garbage: see abandon_unfinished(). Errors: as
/// Database::error().
Result<RestoredScene> begin_restored(Database& database, const SceneInfo& info,
                                     std::uint64_t revision);
/// After the snapshot is written: this scene is there, and the one of its name, if there is one, is
/// removed, or is the error if it may not be replaced. Errors: as Database, kAlreadyExists.
Status publish_restored(Database& database, const RestoredScene& restored, bool replace);

}  // namespace sightline::server::store
