// Takes a scene back to an earlier revision.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "accel/result.h"
#include "server/store/file_system.h"

namespace sightline::server::store {

/// Takes a scene of a directory that no process uses back to an earlier revision: later batches,
/// snapshots and answers are dropped, and producers are forgotten. The scene gets `incarnation`,
/// so that revision tokens of what was dropped are not taken for new ones. Errors: kNotFound (the
/// scene), kOutOfRange (a revision that the log does not hold), as DataDirectory::open().
Status roll_back(FileSystem& files, const std::filesystem::path& directory,
                 const std::string& scene, std::uint64_t revision, std::uint64_t incarnation);

}  // namespace sightline::server::store
