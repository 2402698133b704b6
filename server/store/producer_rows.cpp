// The tables of producers and of the nodes that their last batches put.
#include "server/store/producer_rows.h"

#include <fmt/format.h>

#include "server/store/errors.h"
#include "server/store/node_ids.h"

namespace sightline::server::store {
namespace {

Status insert_put(Database& database, SceneId scene, const ProducerCommit& commit,
                  const StoreLimits& limits) {
  const std::string nodes = encode_ids(commit.nodes);
  Status done = database.execute(
      "INSERT INTO put(scene, producer, sequence, node_count, nodes) VALUES(?, ?, ?, ?, ?)", scene,
      commit.producer, commit.sequence, static_cast<std::uint64_t>(commit.nodes.size()),
      as_bytes(nodes));
  if (!done) return done;
  return database.execute(
      "DELETE FROM put WHERE scene = ?1 AND producer = ?2 AND sequence <= coalesce(("
      "SELECT max(sequence) FROM (SELECT sequence, row_number() OVER newest AS number, "
      "sum(node_count) OVER newest AS nodes FROM put WHERE scene = ?1 AND producer = ?2 "
      "WINDOW newest AS (ORDER BY sequence DESC)) AS kept WHERE number > ?3 OR nodes > ?4), 0)",
      scene, commit.producer, limits.puts, limits.put_nodes);
}

/// Rows of one producer follow each other.
Status read_producer(Database& database, SceneId scene, const Row& row,
                     std::vector<ProducerRecord>& into) {
  std::string name = row.text(0);
  if (into.empty() || into.back().name != name) into.push_back({name, row.unsigned_number(1), {}});
  const std::uint64_t sequence = row.unsigned_number(2);
  if (sequence == 0) return {};  // it has put no nodes
  auto nodes = decode_ids(row.bytes(3));
  if (!nodes) {
    return database.corrupt(
        fmt::format("the producer {} of the scene with the number {}", name, scene));
  }
  into.back().recent.push_back({std::move(name), sequence, std::move(*nodes)});
  return {};
}

}  // namespace

Status insert_commit(Database& database, SceneId scene, const ProducerCommit& commit,
                     const StoreLimits& limits) {
  Status done = database.execute(
      "INSERT INTO producer(scene, name, last_committed) VALUES(?, ?, ?) ON CONFLICT(scene, name) "
      "DO UPDATE SET last_committed = excluded.last_committed "
      "WHERE excluded.last_committed > producer.last_committed",
      scene, commit.producer, commit.sequence);
  if (!done) return done;
  if (database.changes() == 0) {
    return Error{
        Code::kOutOfRange,
        fmt::format("batch {} of the producer {} is stored", commit.sequence, commit.producer),
        "SEQUENCE_KNOWN"};
  }
  if (commit.nodes.empty()) return {};
  return insert_put(database, scene, commit, limits);
}

Result<std::vector<ProducerRecord>> read_producers(Database& database, SceneId scene) {
  std::vector<ProducerRecord> producers;
  const Status read = database.each(
      "SELECT name, last_committed, sequence, nodes FROM producer LEFT JOIN put "
      "ON put.scene = producer.scene AND put.producer = producer.name "
      "WHERE producer.scene = ? ORDER BY name, sequence",
      [&](const Row& row) { return read_producer(database, scene, row, producers); }, scene);
  if (!read) return read.error();
  return producers;
}

Result<std::optional<ProducerRecord>> find_producer(Database& database, SceneId scene,
                                                    const std::string& name) {
  std::vector<ProducerRecord> producers;
  const Status read = database.each(
      "SELECT name, last_committed, sequence, nodes FROM producer LEFT JOIN put "
      "ON put.scene = producer.scene AND put.producer = producer.name "
      "WHERE producer.scene = ? AND producer.name = ? ORDER BY sequence",
      [&](const Row& row) { return read_producer(database, scene, row, producers); }, scene, name);
  if (!read) return read.error();
  if (producers.empty()) return std::optional<ProducerRecord>();
  return std::optional(std::move(producers.front()));
}

}  // namespace sightline::server::store
