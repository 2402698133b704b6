// Steps that tests of a store share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "server/store/sqlite_store.h"

namespace sightline::tests {

/// The bytes of a blob, different for each number.
std::string blob_bytes(int number, std::size_t size = 1000);
server::blobs::BlobDigest digest_of_blob(const std::string& bytes);

Status store_blob(server::store::Store& store, const std::string& bytes);
/// The bytes of a stored blob.
Result<std::string> load_blob(server::store::Store& store, const server::blobs::BlobDigest& digest);

/// Appends and waits until it is done.
Status append(server::store::Store& store, server::store::Batch batch);
/// The same with these updates at this revision.
Status append(server::store::Store& store, server::store::SceneId scene, std::uint64_t expected,
              const std::string& updates, const std::vector<server::blobs::BlobDigest>& blobs = {});

/// A scene with this name; fails the test if it cannot be made.
server::store::SceneId make_scene(server::store::Store& store, const std::string& name);

/// Updates of all revisions from `after` on, in order.
Result<std::vector<std::string>> log_of(server::store::Store& store, server::store::SceneId scene,
                                        std::uint64_t after = 0);

Status put_snapshot(server::store::Store& store, server::store::SceneId scene,
                    std::uint64_t revision, std::vector<std::string> chunks,
                    const std::vector<server::blobs::BlobDigest>& blobs = {});

/// "" for success, else the reason.
template <class T>
std::string reason_of(const Result<T>& result) {
  return result ? std::string() : result.error().reason;
}

/// Limits without a least free disk, for small disks.
server::store::StoreLimits small_disk();

/// Fails the test if the directory cannot be opened.
std::unique_ptr<server::store::SqliteStore> open_store(
    const std::filesystem::path& directory,
    server::store::FileSystem& files = server::store::local_files());

}  // namespace sightline::tests
