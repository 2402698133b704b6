// Blobs in PostgreSQL, with copies on this machine.
#include "server/store/postgres/meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "server/store/milliseconds.h"
#include "server/store/postgres/content_rows.h"
#include "server/store/postgres/lease.h"
#include "server/store/postgres/tables.h"

namespace sightline::server::store::postgres {
namespace {

/// Chunks of a content that are written in one transaction, and read in one.
constexpr std::uint64_t kChunksAtOnce = 8;
/// A mesh of at most this number of bytes is written with others, by the thread that commits; a
/// larger one would hold up their commits.
constexpr std::size_t kSmallMesh = std::size_t{64} << 10;
static_assert(kSmallMesh <= kContentChunk);
/// Blobs that one transaction removes.
constexpr std::size_t kRemovedInOne = 256;
constexpr const char* kSweepLease = "sweep";
/// A blob that is asked for is written at most this often.
constexpr std::chrono::minutes kTouchEvery{5};

class CachedBlob final : public BlobBytes {
 public:
  explicit CachedBlob(std::unique_ptr<MappedFile> file) : file_(std::move(file)) {}
  std::span<const std::byte> bytes() const override { return file_->bytes(); }

 private:
  std::unique_ptr<MappedFile> file_;
};

std::uint64_t chunks_of(std::uint64_t bytes) { return (bytes + kContentChunk - 1) / kContentChunk; }

std::span<const std::byte> chunk_of(std::span<const std::byte> bytes, std::uint64_t number) {
  const std::uint64_t begin = number * kContentChunk;
  return bytes.subspan(begin, std::min(kContentChunk, bytes.size() - begin));
}

}  // namespace

/// Gathers the bytes in a file of the cache, from which they are uploaded.
class Meshes::Writing final : public BlobWriter {
 public:
  Writing(Meshes& meshes, const blobs::BlobDigest& digest, std::unique_ptr<MeshCache::Copy> copy)
      : meshes_(meshes), digest_(digest), copy_(std::move(copy)) {}

  Status append(std::span<const std::byte> bytes) override {
    if (bytes.size() > digest_.size - written_) {
      return Error{Code::kInvalidArgument,
                   fmt::format("{} bytes arrived beyond the end of {}",
                               bytes.size() - (digest_.size - written_), digest_.text()),
                   "BLOB_TOO_LONG"};
    }
    if (Status copied = copy_->append(bytes); !copied) return copied;
    written_ += bytes.size();
    return {};
  }

  Status finish() override {
    const auto mapped = copy_->keep(digest_);
    if (!mapped) return mapped.error();
    return meshes_.upload(digest_, (*mapped)->bytes());
  }

 private:
  Meshes& meshes_;
  const blobs::BlobDigest digest_;
  std::unique_ptr<MeshCache::Copy> copy_;
  std::uint64_t written_ = 0;
};

Result<std::unique_ptr<BlobWriter>> Meshes::write(const blobs::BlobDigest& digest) {
  if (has(std::span(&digest, 1)).front())
    return Error{Code::kAlreadyExists, digest.text() + " is stored", "BLOB_STORED"};
  auto copy = cache_.create(digest.size);
  if (!copy) return copy.error();
  return std::unique_ptr<BlobWriter>(std::make_unique<Writing>(*this, digest, std::move(*copy)));
}

Status Meshes::upload(const blobs::BlobDigest& digest, std::span<const std::byte> bytes) {
  Status stored = bytes.size() <= kSmallMesh
                      ? writer_.perform(0,
                                        [&](Database& database) {
                                          return insert_blob_of_chunk(database, digest, bytes);
                                        })
                      : upload_large(digest, bytes);
  if (stored) remember_corrupt(digest, false);
  return stored;
}

/// Chunks that are written before an error are garbage, which the compactor finds by its age.
Status Meshes::upload_large(const blobs::BlobDigest& digest, std::span<const std::byte> bytes) {
  auto content = write_content(bytes);
  // It may have been kept all the same, but then as garbage: another one is as good.
  if (!content && content.error().reason == "STORE_IO") content = write_content(bytes);
  if (!content) return content.error();
  return writer_.perform(
      0, [&](Database& database) { return name_content(database, digest, *content); });
}

Result<std::int64_t> Meshes::write_content(std::span<const std::byte> bytes) {
  std::int64_t content = 0;
  const std::uint64_t chunks = chunks_of(bytes.size());
  for (std::uint64_t first = 0; first == 0 || first < chunks; first += kChunksAtOnce) {
    const Status written = pool_.write([&](Database& database) -> Status {
      if (first == 0) {
        const auto begun = begin_content(database);
        if (!begun) return begun.error();
        content = *begun;
      }
      for (std::uint64_t i = first; i < std::min(first + kChunksAtOnce, chunks); ++i) {
        Status done = insert_content_chunk(database, content, i, chunk_of(bytes, i));
        if (!done) return done;
      }
      return {};
    });
    if (!written) return written.error();
  }
  return content;
}

std::vector<bool> Meshes::has(std::span<const blobs::BlobDigest> digests) {
  std::vector<bool> there(digests.size());
  std::set<blobs::BlobDigest> found;
  const Status asked = pool_.ask_much([&](Database& database) -> Status {
    auto some = find_and_touch(database, digests, kTouchEvery);
    if (!some) return some.error();
    found = std::move(*some);
    return {};
  });
  if (!asked) return there;
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < digests.size(); ++i)
    there[i] = found.contains(digests[i]) && !corrupt_.contains(digests[i]);
  return there;  // a damaged blob can be stored again
}

Result<std::shared_ptr<const BlobBytes>> Meshes::get(const blobs::BlobDigest& digest) {
  auto mapped = cache_.find(digest);
  if (!mapped) {
    auto fetched = fetch(digest);
    // While it was read, it may have got another content.
    if (!fetched && fetched.error().reason == "BLOB_CORRUPT") fetched = fetch(digest);
    if (!fetched) {
      if (fetched.error().reason == "BLOB_CORRUPT") remember_corrupt(digest, true);
      return fetched.error();
    }
    mapped = std::move(*fetched);
  }
  return std::shared_ptr<const BlobBytes>(std::make_shared<CachedBlob>(std::move(mapped)));
}

Result<std::unique_ptr<MappedFile>> Meshes::fetch(const blobs::BlobDigest& digest) {
  const auto content = pool_([&](Database& database) { return find_content(database, digest); });
  if (!content) return content.error();
  if (!*content) return Error{Code::kNotFound, digest.text() + " is not stored", "BLOB_NOT_STORED"};
  auto copied = cache_.create(digest.size);
  if (!copied) return copied.error();
  if (const Status filled = copy(digest, **content, **copied); !filled) return filled.error();
  auto mapped = (*copied)->keep(digest);
  if (!mapped && mapped.error().code == Code::kDataLoss) {
    return Error{Code::kDataLoss,
                 fmt::format("the bytes of {} in the store are damaged; upload it again, or "
                             "restore a backup",
                             digest.text()),
                 "BLOB_CORRUPT"};
  }
  return mapped;
}

/// A chunk that is missing makes the copy too short.
Status Meshes::copy(const blobs::BlobDigest& digest, std::int64_t content, MeshCache::Copy& copy) {
  const std::uint64_t chunks = chunks_of(digest.size);
  for (std::uint64_t first = 0; first < chunks; first += kChunksAtOnce) {
    std::vector<std::string> some;
    Status read = pool_([&](Database& database) -> Status {
      some.clear();
      for (std::uint64_t i = first; i < std::min(first + kChunksAtOnce, chunks); ++i) {
        Status found = database.each(
            "SELECT data FROM content_chunk WHERE content = ? AND number = ?",
            [&](const Row& row) {
              some.push_back(row.copy_of_bytes(0));
              return Status();
            },
            content, i);
        if (!found) return found;
      }
      return {};
    });
    if (!read) return read;
    for (const std::string& chunk : some) {
      if (Status written = copy.append(as_bytes(chunk)); !written) return written;
    }
  }
  return {};
}

Result<std::uint64_t> Meshes::sweep(std::chrono::steady_clock::duration grace,
                                    const std::function<bool(const blobs::BlobDigest&)>& in_use) {
  const auto time = begin_sweep();
  if (!time) return time.error();
  if (!*time) return std::uint64_t{0};
  const auto before = from_milliseconds(
      **time + 1 - std::chrono::duration_cast<std::chrono::milliseconds>(grace).count());
  auto unnamed = pool_([&](Database& database) { return unnamed_blobs(database, before); });
  if (!unnamed) return unnamed.error();
  if (in_use) std::erase_if(*unnamed, [&](const BlobRow& row) { return in_use(row.digest); });
  auto removed = remove_all(*unnamed, before);
  end_sweep();
  return removed;
}

Result<std::optional<std::int64_t>> Meshes::begin_sweep() {
  std::optional<std::int64_t> time;
  const Status asked = pool_.write([&](Database& database) -> Status {
    const auto mine = take_lease(database, kSweepLease, name_);
    if (!mine) return mine.error();
    const auto current = now(database);
    if (!current) return current.error();
    if (*mine) time = *current;
    return {};
  });
  if (!asked) return asked.error();
  return time;
}

/// If it fails, the lease ends by itself.
void Meshes::end_sweep() {
  (void)pool_.write(
      [&](Database& database) { return release_lease(database, kSweepLease, name_); });
}

Result<std::uint64_t> Meshes::remove_all(std::span<const BlobRow> rows,
                                         std::chrono::system_clock::time_point before) {
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < rows.size(); i += kRemovedInOne) {
    auto removed = remove_some(rows.subspan(i, std::min(kRemovedInOne, rows.size() - i)), before);
    if (!removed) return removed;
    bytes += *removed;
  }
  return bytes;
}

Result<std::uint64_t> Meshes::remove_some(std::span<const BlobRow> rows,
                                          std::chrono::system_clock::time_point before) {
  std::vector<blobs::BlobDigest> removed;
  const Status done = writer_.perform(0, [&](Database& database) -> Status {
    removed.clear();
    for (const BlobRow& row : rows) {
      const auto locked = lock_blob(database, row.id, before);
      if (!locked) return locked.error();
      if (!*locked) continue;
      const auto deleted = delete_with_content(database, row.id);
      if (!deleted) return deleted.error();
      if (*deleted) removed.push_back(row.digest);
    }
    return {};
  });
  if (!done) return done.error();
  std::uint64_t bytes = 0;
  for (const blobs::BlobDigest& digest : removed) {
    cache_.remove(digest);
    bytes += digest.size;
  }
  return bytes;
}

BlobTotals Meshes::totals() {
  const auto totals = pool_([](Database& database) { return blob_totals(database); });
  return totals ? *totals : BlobTotals();
}

void Meshes::remember_corrupt(const blobs::BlobDigest& digest, bool corrupt) {
  const std::lock_guard lock(mutex_);
  if (corrupt) {
    corrupt_.insert(digest);
  } else {
    corrupt_.erase(digest);
  }
}

}  // namespace sightline::server::store::postgres
