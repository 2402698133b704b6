// The bytes of blobs as rows: chunks of a content, which a blob names when it is complete.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>

#include "proto/result.h"
#include "server/blobs/digest.h"
#include "server/store/database.h"

namespace sightline::server::store::postgres {

/// Bytes of all chunks but the last.
inline constexpr std::uint64_t kContentChunk = std::uint64_t{1} << 20;

/// Errors of all: as Database.

/// Returns the id of a content without chunks.
Result<std::int64_t> begin_content(Database& database);
Status insert_content_chunk(Database& database, std::int64_t content, std::uint64_t number,
                            std::span<const std::byte> bytes);
/// Makes the content that of the blob, which is stored from now on. What the blob had is garbage.
Status name_content(Database& database, const blobs::BlobDigest& digest, std::int64_t content);
/// Stores a blob of at most kContentChunk bytes, as the three before do, in one round trip unless
/// it is stored already.
Status insert_blob_of_chunk(Database& database, const blobs::BlobDigest& digest,
                            std::span<const std::byte> bytes);
/// The content of a blob; nothing if it is not stored.
Result<std::optional<std::int64_t>> find_content(Database& database,
                                                 const blobs::BlobDigest& digest);
/// The digests that are stored. The grace period of those that were not asked for within `every`
/// begins anew.
Result<std::set<blobs::BlobDigest>> find_and_touch(Database& database,
                                                   std::span<const blobs::BlobDigest> digests,
                                                   std::chrono::milliseconds every);
/// Locks a blob that was not touched after `before`. Returns false if it was, is gone, or another
/// transaction is about to name it.
Result<bool> lock_blob(Database& database, std::int64_t blob,
                       std::chrono::system_clock::time_point before);
/// Deletes a blob unless something names it; then its content is garbage. Returns whether it was
/// deleted.
Result<bool> delete_with_content(Database& database, std::int64_t blob);
/// Deletes a bounded number of chunks that no blob has named for an hour. Returns whether there may
/// be more.
Result<bool> purge_contents(Database& database);

}  // namespace sightline::server::store::postgres
