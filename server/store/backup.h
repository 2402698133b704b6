// Copies of a data directory.
#pragma once

#include <filesystem>

#include "accel/result.h"
#include "server/store/blob_files.h"
#include "server/store/data_directory.h"

namespace sightline::server::store {

/// As SqliteStore::backup(). `from` may be in use by this process; no blob may be removed
/// meanwhile. A blob whose file is missing is left out, as a finding for the doctor.
Status copy_store(const DataDirectory& from, const BlobFiles& blobs,
                  const std::filesystem::path& to);

/// Copies a backup, or any data directory that no process uses, to one that is empty or missing.
/// Errors: as DataDirectory::open() and SqliteStore::backup().
Status restore_store(FileSystem& files, const std::filesystem::path& from,
                     const std::filesystem::path& to);

}  // namespace sightline::server::store
