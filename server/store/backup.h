// Copies of a data directory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "accel/result.h"
#include "server/store/blob_files.h"
#include "server/store/data_directory.h"

namespace sightline::server::store {

/// As SqliteStore::backup(). `from` may be in use by this process. No blob may be removed
/// meanwhile.
Status copy_store(const DataDirectory& from, const BlobFiles& blobs,
                  const std::filesystem::path& to);

/// Copies a backup, or any data directory that no process uses, to one that is empty or missing.
/// Errors: as DataDirectory::open() and SqliteStore::backup().
Status restore_store(FileSystem& files, const std::filesystem::path& from,
                     const std::filesystem::path& to);

/// Takes a scene of a directory that no process uses back to an earlier revision: later batches,
/// snapshots and answers are dropped, and producers are forgotten. The scene gets `incarnation`,
/// so that revision tokens of what was dropped are not taken for new ones. Errors: kNotFound (the
/// scene), kOutOfRange (a revision that the log does not hold), as DataDirectory::open().
Status roll_back(FileSystem& files, const std::filesystem::path& directory,
                 const std::string& scene, std::uint64_t revision, std::uint64_t incarnation);

}  // namespace sightline::server::store
