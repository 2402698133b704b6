// The table of answers to requests with a request id.
#include "server/store/answer_rows.h"

#include <fmt/format.h>

#include "server/store/errors.h"
#include "server/store/node_ids.h"

namespace sightline::server::store {
namespace {

struct Kept {
  std::uint64_t answers = 0;
  std::uint64_t nodes = 0;
};

Result<Kept> find_kept(Database& database, SceneId scene) {
  Kept kept;
  const Status read = database.each(
      "SELECT answers, answer_nodes FROM scene WHERE id = ?",
      [&](const Row& row) {
        kept = {row.unsigned_number(0), row.unsigned_number(1)};
        return Status();
      },
      scene);
  if (!read) return read.error();
  return kept;
}

Status read_answer(Database& database, SceneId scene, const Row& row,
                   std::vector<RequestAnswer>& into) {
  auto nodes = decode_ids(row.bytes(3));
  if (!nodes)
    return database.corrupt(fmt::format("an answer of the scene with the number {}", scene));
  into.push_back({row.text(0), row.unsigned_number(1), row.unsigned_number(2), std::move(*nodes)});
  return {};
}

/// Drops the oldest answers until the limits hold, but never the newest.
Status trim(Database& database, SceneId scene, Kept& kept, const StoreLimits& limits) {
  while (kept.answers > 1 && (kept.answers > limits.answers || kept.nodes > limits.answer_nodes)) {
    std::uint64_t nodes = 0;
    std::int64_t id = 0;
    Status done = database.each(
        "SELECT id, node_count FROM answer WHERE scene = ? ORDER BY id LIMIT 1",
        [&](const Row& row) {
          id = row.number(0);
          nodes = row.unsigned_number(1);
          return Status();
        },
        scene);
    if (done) done = database.execute("DELETE FROM answer WHERE id = ?", id);
    if (!done) return done;
    kept.answers -= 1;
    kept.nodes -= nodes;
  }
  return {};
}

}  // namespace

Status insert_answer(Database& database, SceneId scene, const RequestAnswer& answer,
                     const StoreLimits& limits) {
  const std::string nodes = encode_ids(answer.nodes);
  Status done = database.execute(
      "INSERT INTO answer(scene, request_id, content, revision, node_count, nodes) "
      "VALUES(?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING",
      scene, answer.request_id, answer.content, answer.revision,
      static_cast<std::uint64_t>(answer.nodes.size()), as_bytes(nodes));
  if (!done) return done;
  if (database.changes() == 0) {
    return Error{Code::kAlreadyExists, "the request id is stored with another answer",
                 "REQUEST_ID_KNOWN"};
  }
  auto kept = find_kept(database, scene);
  if (!kept) return kept.error();
  kept->answers += 1;
  kept->nodes += answer.nodes.size();
  if (done = trim(database, scene, *kept, limits); !done) return done;
  return database.execute("UPDATE scene SET answers = ?, answer_nodes = ? WHERE id = ?",
                          kept->answers, kept->nodes, scene);
}

Result<std::vector<RequestAnswer>> read_answers(Database& database, SceneId scene) {
  std::vector<RequestAnswer> answers;
  const Status read = database.each(
      "SELECT request_id, content, revision, nodes FROM answer WHERE scene = ? ORDER BY id",
      [&](const Row& row) { return read_answer(database, scene, row, answers); }, scene);
  if (!read) return read.error();
  return answers;
}

Result<std::optional<RequestAnswer>> find_answer(Database& database, SceneId scene,
                                                 const std::string& request_id) {
  std::vector<RequestAnswer> answers;
  const Status read = database.each(
      "SELECT request_id, content, revision, nodes FROM answer "
      "WHERE scene = ? AND request_id = ?",
      [&](const Row& row) { return read_answer(database, scene, row, answers); }, scene,
      request_id);
  if (!read) return read.error();
  if (answers.empty()) return std::optional<RequestAnswer>();
  return std::optional(std::move(answers.front()));
}

}  // namespace sightline::server::store
