// The bytes of blobs as rows: chunks of a content, which a blob names when it is complete.
#include "server/store/postgres/content_rows.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>
#include <string>

#include "server/store/blob_rows.h"
#include "server/store/milliseconds.h"
#include "server/store/postgres/tables.h"

namespace sightline::server::store::postgres {
namespace {

/// A content that no blob names after this is of a process that has died.
constexpr std::chrono::hours kUploadTime{1};

std::span<const std::byte> sum_bytes(const blobs::BlobDigest& digest) {
  return std::as_bytes(std::span(digest.sum));
}

/// Makes the content garbage when the transaction ends.
Status drop_content(Database& database, std::int64_t content) {
  return database.execute("UPDATE content SET named = 0, begun = 0 WHERE id = ?", content);
}

}  // namespace

Result<std::int64_t> begin_content(Database& database) {
  const auto time = now(database);
  if (!time) return time.error();
  const auto id = database.number("INSERT INTO content(begun) VALUES(?) RETURNING id", *time);
  if (!id) return id.error();
  return id->value_or(0);
}

Status insert_content_chunk(Database& database, std::int64_t content, std::uint64_t number,
                            std::span<const std::byte> bytes) {
  return database.execute("INSERT INTO content_chunk VALUES(?, ?, ?)", content, number, bytes);
}

Status name_content(Database& database, const blobs::BlobDigest& digest, std::int64_t content) {
  const auto time = now(database);
  if (!time) return time.error();
  const auto fresh = database.number(
      "INSERT INTO blob(sum, size, stored, content) VALUES(?, ?, ?, ?) "
      "ON CONFLICT(sum) DO NOTHING RETURNING id",
      sum_bytes(digest), digest.size, *time, content);
  if (!fresh) return fresh.error();
  Status done;
  if (!*fresh) {
    const auto old = database.number("SELECT content FROM blob WHERE sum = ? FOR NO KEY UPDATE",
                                     sum_bytes(digest));
    if (!old) return old.error();
    if (done = drop_content(database, old->value_or(0)); !done) return done;
    done = database.execute("UPDATE blob SET content = ?, stored = ? WHERE sum = ?", content, *time,
                            sum_bytes(digest));
  }
  if (!done) return done;
  return database.execute("UPDATE content SET named = 1 WHERE id = ?", content);
}

Status insert_blob_of_chunk(Database& database, const blobs::BlobDigest& digest,
                            std::span<const std::byte> bytes) {
  std::int64_t content = 0;
  bool named = false;
  const Status done = database.each(
      "WITH time AS (SELECT CAST(extract(epoch FROM clock_timestamp()) * 1000 AS BIGINT) AS now), "
      "fresh AS (INSERT INTO content(begun, named) SELECT now, 1 FROM time RETURNING id), "
      "chunk AS (INSERT INTO content_chunk SELECT id, 0, ?3 FROM fresh), "
      "named AS (INSERT INTO blob(sum, size, stored, content) "
      "SELECT ?1, ?2, now, id FROM fresh, time ON CONFLICT(sum) DO NOTHING RETURNING id) "
      "SELECT fresh.id, coalesce(named.id, 0) FROM fresh LEFT JOIN named ON TRUE",
      [&](const Row& row) {
        content = row.number(0);
        named = row.number(1) != 0;
        return Status();
      },
      sum_bytes(digest), digest.size, bytes);
  return !done || named ? done : name_content(database, digest, content);
}

Result<std::optional<std::int64_t>> find_content(Database& database,
                                                 const blobs::BlobDigest& digest) {
  return database.number("SELECT content FROM blob WHERE sum = ? AND size = ?", sum_bytes(digest),
                         digest.size);
}

/// Waits for the rows that have to be touched, in an order that all callers share: one that is
/// being swept is gone then. Writes nothing if no row has to be touched.
Result<std::set<blobs::BlobDigest>> find_and_touch(Database& database,
                                                   std::span<const blobs::BlobDigest> digests,
                                                   std::chrono::milliseconds every) {
  std::string sums = "{";
  for (const blobs::BlobDigest& digest : digests)
    sums += fmt::format("{}\"\\\\x{:02x}\"", sums.size() > 1 ? "," : "", fmt::join(digest.sum, ""));
  sums += "}";
  std::set<blobs::BlobDigest> found;
  const Status read = database.each(
      "WITH time AS (SELECT CAST(extract(epoch FROM clock_timestamp()) * 1000 AS BIGINT) AS now), "
      "asked AS MATERIALIZED (SELECT id, blob.sum, size, stored FROM "
      "unnest(CAST(?1 AS BYTEA[])) AS wanted(sum) JOIN blob ON blob.sum = wanted.sum), "
      "old AS (SELECT id FROM blob WHERE id IN "
      "(SELECT id FROM asked, time WHERE stored < now - ?2) ORDER BY id FOR NO KEY UPDATE), "
      "touched AS (UPDATE blob SET stored = now FROM old, time WHERE blob.id = old.id "
      "RETURNING blob.sum, size) "
      "SELECT sum, size FROM touched UNION SELECT sum, size FROM asked, time "
      "WHERE stored >= now - ?2",
      [&](const Row& row) {
        blobs::BlobDigest digest;
        const auto sum = row.bytes(0);
        if (sum.size() != digest.sum.size()) return Status();
        std::memcpy(digest.sum.data(), sum.data(), sum.size());
        digest.size = row.unsigned_number(1);
        found.insert(digest);
        return Status();
      },
      sums, static_cast<std::int64_t>(every.count()));
  if (!read) return read.error();
  return found;
}

Result<bool> lock_blob(Database& database, std::int64_t blob,
                       std::chrono::system_clock::time_point before) {
  const auto id =
      database.number("SELECT id FROM blob WHERE id = ? AND stored < ? FOR UPDATE SKIP LOCKED",
                      blob, to_milliseconds(before));
  if (!id) return id.error();
  return id->has_value();
}

Result<bool> delete_with_content(Database& database, std::int64_t blob) {
  const auto content = database.number("SELECT content FROM blob WHERE id = ?", blob);
  if (!content) return content.error();
  auto deleted = delete_unnamed(database, blob);
  if (!deleted || !*deleted) return deleted;
  if (const Status dropped = drop_content(database, content->value_or(0)); !dropped)
    return dropped.error();
  return true;
}

Result<bool> purge_contents(Database& database) {
  const auto time = now(database);
  if (!time) return time.error();
  const auto content = database.number(
      "SELECT id FROM content WHERE named = 0 AND begun < ? ORDER BY begun LIMIT 1 "
      "FOR UPDATE SKIP LOCKED",
      *time - std::chrono::milliseconds(kUploadTime).count());
  if (!content) return content.error();
  if (!*content) return false;
  Status done = database.execute(
      "DELETE FROM content_chunk WHERE (content, number) IN "
      "(SELECT content, number FROM content_chunk WHERE content = ? LIMIT 64)",
      **content);
  if (done && database.changes() == 0)
    done = database.execute("DELETE FROM content WHERE id = ?", **content);
  if (!done) return done.error();
  return true;
}

}  // namespace sightline::server::store::postgres
