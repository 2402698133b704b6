// The tables of producers and of the nodes that their last batches put.
#include "server/store/producer_rows.h"

#include <fmt/format.h>

#include "server/store/errors.h"
#include "server/store/node_ids.h"

namespace sightline::server::store {
namespace {

Error damaged_producer(const Database& database, SceneId scene, const std::string& name) {
  return database.corrupt(fmt::format(
      "the producer {} of the scene with the number {} does not match its checksum", name, scene));
}

Status insert_put(Database& database, SceneRow& scene, const ProducerCommit& commit,
                  const StoreLimits& limits) {
  const std::string nodes = encode_ids(commit.nodes);
  const std::int64_t seal = seal_put(scene.key, commit.producer, commit.sequence, nodes);
  Status done = database.execute(
      "INSERT INTO put(scene, producer, sequence, node_count, nodes, seal) "
      "VALUES(?, ?, ?, ?, ?, ?)",
      scene.key.id, commit.producer, commit.sequence,
      static_cast<std::uint64_t>(commit.nodes.size()), as_bytes(nodes), seal);
  if (!done) return done;
  scene.producer_sum += to_sum(seal);
  return database.each(
      "DELETE FROM put WHERE scene = ?1 AND producer = ?2 AND sequence <= coalesce(("
      "SELECT max(sequence) FROM (SELECT sequence, row_number() OVER newest AS number, "
      "sum(node_count) OVER newest AS nodes FROM put WHERE scene = ?1 AND producer = ?2 "
      "WINDOW newest AS (ORDER BY sequence DESC)) AS kept WHERE number > ?3 OR nodes > ?4), 0) "
      "RETURNING seal",
      [&](const Row& row) {
        scene.producer_sum -= to_sum(row.number(0));
        return Status();
      },
      scene.key.id, commit.producer, limits.puts, limits.put_nodes);
}

/// Adds a row to its producer's record: rows of one producer follow each other. Adds their seals to
/// `sum`.
Status read_producer(Database& database, const SceneKey& scene, const Row& row,
                     std::vector<ProducerRecord>& into, std::uint64_t& sum) {
  std::string name = row.text(0);
  if (into.empty() || into.back().name != name) {
    const std::uint64_t last = row.unsigned_number(1);
    const std::int64_t seal = seal_producer(scene, name, last);
    if (seal != row.number(2)) return damaged_producer(database, scene.id, name);
    sum += to_sum(seal);
    into.push_back({name, last, {}});
  }
  const std::uint64_t sequence = row.unsigned_number(3);
  if (sequence == 0) return {};  // it has put no nodes
  auto nodes = decode_ids(row.bytes(4));
  const std::int64_t seal = seal_put(scene, name, sequence, row.copy_of_bytes(4));
  if (!nodes || seal != row.number(5) || sequence > into.back().last_committed)
    return damaged_producer(database, scene.id, name);
  sum += to_sum(seal);
  into.back().recent.push_back({std::move(name), sequence, std::move(*nodes)});
  return {};
}

struct Progress {
  std::uint64_t last = 0;
  std::int64_t seal = 0;
};

/// The producer's progress; nothing if it has committed nothing.
Result<std::optional<Progress>> find_progress(Database& database, const SceneKey& scene,
                                              const std::string& name) {
  std::optional<Progress> found;
  const Status read = database.each(
      "SELECT last_committed, seal FROM producer WHERE scene = ? AND name = ?",
      [&](const Row& row) -> Status {
        found = {row.unsigned_number(0), row.number(1)};
        if (seal_producer(scene, name, found->last) == found->seal) return {};
        return damaged_producer(database, scene.id, name);
      },
      scene.id, name);
  if (!read) return read.error();
  return found;
}

}  // namespace

std::int64_t seal_producer(const SceneKey& scene, std::string_view name,
                           std::uint64_t last_committed) {
  return Seal(RowKind::kProducer, scene).add(name).add(last_committed).value();
}

std::int64_t seal_put(const SceneKey& scene, std::string_view producer, std::uint64_t sequence,
                      std::string_view nodes) {
  return Seal(RowKind::kPut, scene).add(producer).add(sequence).add(nodes).value();
}

Status insert_commit(Database& database, SceneRow& scene, const ProducerCommit& commit,
                     const StoreLimits& limits) {
  const auto before = find_progress(database, scene.key, commit.producer);
  if (!before) return before.error();
  if (*before && commit.sequence <= (*before)->last) {
    return Error{
        Code::kOutOfRange,
        fmt::format("batch {} of the producer {} is stored", commit.sequence, commit.producer),
        "SEQUENCE_KNOWN"};
  }
  const std::int64_t seal = seal_producer(scene.key, commit.producer, commit.sequence);
  Status done = *before ? database.execute(
                              "UPDATE producer SET last_committed = ?, seal = ? "
                              "WHERE scene = ? AND name = ?",
                              commit.sequence, seal, scene.key.id, commit.producer)
                        : database.execute(
                              "INSERT INTO producer(last_committed, seal, scene, name) "
                              "VALUES(?, ?, ?, ?)",
                              commit.sequence, seal, scene.key.id, commit.producer);
  if (!done) return done;
  scene.producer_sum += to_sum(seal) - (*before ? to_sum((*before)->seal) : 0);
  if (commit.nodes.empty()) return {};
  return insert_put(database, scene, commit, limits);
}

Result<std::vector<ProducerRecord>> read_producers(Database& database, SceneId scene) {
  const auto row = read_scene(database, scene);
  if (!row) return row.error();
  std::vector<ProducerRecord> producers;
  std::uint64_t sum = 0;
  const Status read = database.each(
      "SELECT name, last_committed, producer.seal, sequence, nodes, put.seal FROM producer "
      "LEFT JOIN put ON put.scene = producer.scene AND put.producer = producer.name "
      "WHERE producer.scene = ? ORDER BY name, sequence",
      [&](const Row& found) { return read_producer(database, row->key, found, producers, sum); },
      scene);
  if (!read) return read.error();
  if (sum == row->producer_sum) return producers;
  return database.corrupt(
      fmt::format("rows of producers of the scene with the number {} are missing", scene));
}

Result<std::optional<ProducerRecord>> find_producer(Database& database, SceneId scene,
                                                    const std::string& name) {
  const auto row = read_scene(database, scene);
  if (!row) return row.error();
  std::vector<ProducerRecord> producers;
  std::uint64_t sum = 0;
  const Status read = database.each(
      "SELECT name, last_committed, producer.seal, sequence, nodes, put.seal FROM producer "
      "LEFT JOIN put ON put.scene = producer.scene AND put.producer = producer.name "
      "WHERE producer.scene = ? AND producer.name = ? ORDER BY sequence",
      [&](const Row& found) { return read_producer(database, row->key, found, producers, sum); },
      scene, name);
  if (!read) return read.error();
  if (producers.empty()) return std::optional<ProducerRecord>();
  return std::optional(std::move(producers.front()));
}

}  // namespace sightline::server::store
