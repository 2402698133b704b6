// Looks for damage in a data directory that no process uses.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/file_system.h"

namespace sightline::server::store {

/// What an examination has found.
struct Examination {
  std::vector<std::string> findings;  ///< A line each: what is damaged, and what is lost by it.
  std::vector<std::string> repairs;   ///< A line each: what was done.
};

struct Treatment {
  bool repair = false;
  bool accept_loss = false;
};

/// Checks the database, the checksums and revisions of all logs and snapshots, whether these are as
/// new as the marks beside the database say, and the digests of all blobs. With `accept_loss`,
/// scenes whose log was cut go on, as accept_history() says. With `repair`, damaged blobs are moved
/// to lost/ in the directory, so that they can be uploaded again, and files that no row names are
/// removed. What the rows have lost stays lost. Reads everything: it takes as long as the disk
/// needs for that. Errors: kNotFound (there is no database), as DataDirectory::open() and
/// DataDirectory::open_database().
Result<Examination> examine(FileSystem& files, const std::filesystem::path& directory,
                            const Treatment& treatment);

}  // namespace sightline::server::store
