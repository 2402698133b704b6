// The table of blobs, and what names them.
#include "server/store/blob_rows.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <span>

#include "server/store/milliseconds.h"

namespace sightline::server::store {
namespace {

std::span<const std::byte> sum_of(const blobs::BlobDigest& digest) {
  return std::as_bytes(std::span(digest.sum));
}

BlobRow read_row(const Row& row) {
  BlobRow blob;
  blob.id = row.number(0);
  const auto sum = row.bytes(1);
  std::transform(
      sum.begin(),
      sum.begin() + static_cast<std::ptrdiff_t>(std::min(sum.size(), blob.digest.sum.size())),
      blob.digest.sum.begin(), [](std::byte byte) { return std::to_integer<std::uint8_t>(byte); });
  blob.digest.size = row.unsigned_number(2);
  return blob;
}

std::uint64_t to_term(const blobs::BlobDigest& digest) {
  std::uint64_t term = 0;
  std::memcpy(&term, digest.sum.data(), sizeof(term));
  return term;
}

Result<std::uint64_t> sum_rows(Database& database, const char* query, std::int64_t id) {
  std::uint64_t sum = 0;
  const Status read = database.each(
      query,
      [&](const Row& row) {
        sum += to_term(read_row(row).digest);
        return Status();
      },
      id);
  if (!read) return read.error();
  return sum;
}

}  // namespace

std::uint64_t sum_of_blobs(std::span<const blobs::BlobDigest> blobs) {
  std::uint64_t sum = 0;
  for (const blobs::BlobDigest& digest : std::set(blobs.begin(), blobs.end()))
    sum += to_term(digest);
  return sum;
}

Result<std::uint64_t> sum_named_by_batch(Database& database, std::int64_t batch) {
  return sum_rows(database,
                  "SELECT id, sum, size FROM batch_blob JOIN blob ON id = blob WHERE batch = ?",
                  batch);
}

Result<std::uint64_t> sum_named_by_snapshot(Database& database, std::int64_t snapshot) {
  return sum_rows(
      database, "SELECT id, sum, size FROM snapshot_blob JOIN blob ON id = blob WHERE snapshot = ?",
      snapshot);
}

Status insert_blob(Database& database, const blobs::BlobDigest& digest,
                   std::chrono::system_clock::time_point now) {
  return database.execute(
      "INSERT INTO blob(sum, size, stored) VALUES(?, ?, ?) ON CONFLICT DO NOTHING", sum_of(digest),
      digest.size, to_milliseconds(now));
}

Result<std::optional<std::int64_t>> find_blob(Database& database, const blobs::BlobDigest& digest) {
  return database.number("SELECT id FROM blob WHERE sum = ? AND size = ?", sum_of(digest),
                         digest.size);
}

Result<std::vector<BlobRow>> all_blobs(Database& database) {
  std::vector<BlobRow> blobs;
  const Status read =
      database.each("SELECT id, sum, size FROM blob ORDER BY id", [&](const Row& row) {
        blobs.push_back(read_row(row));
        return Status();
      });
  if (!read) return read.error();
  return blobs;
}

Result<BlobTotals> blob_totals(Database& database) {
  BlobTotals totals;
  const Status read =
      database.each("SELECT count(*), CAST(sum(size) AS BIGINT) FROM blob", [&](const Row& row) {
        totals = {row.unsigned_number(0), row.unsigned_number(1)};
        return Status();
      });
  if (!read) return read.error();
  return totals;
}

Result<std::vector<BlobRow>> unnamed_blobs(Database& database,
                                           std::chrono::system_clock::time_point before) {
  std::vector<BlobRow> blobs;
  const Status read = database.each(
      "SELECT id, sum, size FROM blob AS b WHERE stored < ? "
      "AND NOT EXISTS (SELECT 1 FROM batch_blob WHERE blob = b.id) "
      "AND NOT EXISTS (SELECT 1 FROM snapshot_blob WHERE blob = b.id)",
      [&](const Row& row) {
        blobs.push_back(read_row(row));
        return Status();
      },
      to_milliseconds(before));
  if (!read) return read.error();
  return blobs;
}

Result<std::vector<blobs::BlobDigest>> blobs_named_by(Database& database, std::int64_t scene,
                                                      std::uint64_t base) {
  std::vector<blobs::BlobDigest> blobs;
  const Status read = database.each(
      "SELECT id, sum, size FROM blob WHERE id IN "
      "(SELECT blob FROM batch JOIN batch_blob ON batch_blob.batch = batch.id "
      "WHERE scene = ?1 AND revision > ?2 UNION "
      "SELECT blob FROM snapshot JOIN snapshot_blob ON snapshot_blob.snapshot = snapshot.id "
      "WHERE scene = ?1 AND revision = ?2 AND state = 1) ORDER BY id",
      [&](const Row& row) {
        blobs.push_back(read_row(row).digest);
        return Status();
      },
      scene, base);
  if (!read) return read.error();
  return blobs;
}

Result<bool> delete_unnamed(Database& database, std::int64_t blob) {
  const Status deleted = database.execute(
      "DELETE FROM blob WHERE id = ?1 "
      "AND NOT EXISTS (SELECT 1 FROM batch_blob WHERE blob = ?1) "
      "AND NOT EXISTS (SELECT 1 FROM snapshot_blob WHERE blob = ?1)",
      blob);
  if (!deleted) return deleted.error();
  return database.changes() > 0;
}

Result<std::vector<std::string>> scenes_of_blob(Database& database, std::int64_t blob) {
  std::vector<std::string> names;
  const Status read = database.each(
      "SELECT name FROM scene WHERE removed = 0 AND id IN "
      "(SELECT scene FROM batch JOIN batch_blob ON batch = batch.id WHERE blob = ?1 UNION "
      "SELECT scene FROM snapshot JOIN snapshot_blob ON snapshot = snapshot.id WHERE blob = ?1) "
      "ORDER BY name",
      [&](const Row& row) {
        names.push_back(row.text(0));
        return Status();
      },
      blob);
  if (!read) return read.error();
  return names;
}

Result<std::int64_t> need_blob(Database& database, const blobs::BlobDigest& digest) {
  // Where others write, too, the row is held until the transaction ends.
  const auto id =
      database.shared()
          ? database.number("SELECT id FROM blob WHERE sum = ? AND size = ? FOR KEY SHARE",
                            sum_of(digest), digest.size)
          : find_blob(database, digest);
  if (!id) return id.error();
  if (*id) return **id;
  return Error{Code::kFailedPrecondition, digest.text() + " is not stored; upload it again",
               "BLOB_NOT_STORED"};
}

}  // namespace sightline::server::store
