// The table of answers to requests with a request id.
#include "server/store/answer_rows.h"

#include <fmt/format.h>

#include "server/store/errors.h"
#include "server/store/node_ids.h"

namespace sightline::server::store {
namespace {

/// Adds the answer to `into`, and its seal to `sum`.
Status read_answer(Database& database, const SceneKey& scene, const Row& row,
                   std::vector<RequestAnswer>& into, std::uint64_t& sum) {
  const auto bytes = row.bytes(3);
  auto nodes = decode_ids(bytes);
  RequestAnswer answer{row.text(0), row.unsigned_number(1), row.unsigned_number(2), {}};
  if (nodes) answer.nodes = std::move(*nodes);
  const std::int64_t seal = seal_answer(scene, answer, row.copy_of_bytes(3));
  if (!nodes || seal != row.number(4)) {
    return database.corrupt(fmt::format(
        "an answer of the scene with the number {} does not match its checksum", scene.id));
  }
  sum += to_sum(seal);
  into.push_back(std::move(answer));
  return {};
}

/// Drops the oldest answers until the limits hold, but never the newest.
Status trim(Database& database, SceneRow& scene, const StoreLimits& limits) {
  while (scene.answers > 1 &&
         (scene.answers > limits.answers || scene.answer_nodes > limits.answer_nodes)) {
    std::uint64_t nodes = 0;
    std::int64_t id = 0;
    std::uint64_t seal = 0;
    Status done = database.each(
        "SELECT id, node_count, seal FROM answer WHERE scene = ? ORDER BY id LIMIT 1",
        [&](const Row& row) {
          id = row.number(0);
          nodes = row.unsigned_number(1);
          seal = to_sum(row.number(2));
          return Status();
        },
        scene.key.id);
    if (done) done = database.execute("DELETE FROM answer WHERE id = ?", id);
    if (!done) return done;
    if (database.changes() == 0) {
      return database.corrupt(
          fmt::format("answers of the scene with the number {} are missing", scene.key.id));
    }
    scene.answers -= 1;
    scene.answer_nodes -= nodes;
    scene.answer_sum -= seal;
  }
  return {};
}

}  // namespace

std::int64_t seal_answer(const SceneKey& scene, const RequestAnswer& answer,
                         std::string_view nodes) {
  return Seal(RowKind::kAnswer, scene)
      .add(answer.request_id)
      .add(answer.content)
      .add(answer.revision)
      .add(nodes)
      .value();
}

Status insert_answer(Database& database, SceneRow& scene, const RequestAnswer& answer,
                     const StoreLimits& limits) {
  const std::string nodes = encode_ids(answer.nodes);
  const std::int64_t seal = seal_answer(scene.key, answer, nodes);
  Status done = database.execute(
      "INSERT INTO answer(scene, request_id, content, revision, node_count, nodes, seal) "
      "VALUES(?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING",
      scene.key.id, answer.request_id, answer.content, answer.revision,
      static_cast<std::uint64_t>(answer.nodes.size()), as_bytes(nodes), seal);
  if (!done) return done;
  if (database.changes() == 0) {
    return Error{Code::kAlreadyExists, "the request id is stored with another answer",
                 "REQUEST_ID_KNOWN"};
  }
  scene.answers += 1;
  scene.answer_nodes += answer.nodes.size();
  scene.answer_sum += to_sum(seal);
  return trim(database, scene, limits);
}

Result<std::vector<RequestAnswer>> read_answers(Database& database, SceneId scene) {
  const auto row = read_scene(database, scene);
  if (!row) return row.error();
  std::vector<RequestAnswer> answers;
  std::uint64_t sum = 0;
  const Status read = database.each(
      "SELECT request_id, content, revision, nodes, seal FROM answer WHERE scene = ? ORDER BY id",
      [&](const Row& found) { return read_answer(database, row->key, found, answers, sum); },
      scene);
  if (!read) return read.error();
  if (sum == row->answer_sum && answers.size() == row->answers) return answers;
  return database.corrupt(fmt::format(
      "{} answers of the scene with the number {} are found, and others were kept, {} in number",
      answers.size(), scene, row->answers));
}

Result<std::optional<RequestAnswer>> find_answer(Database& database, SceneId scene,
                                                 const std::string& request_id) {
  const auto row = read_scene(database, scene);
  if (!row) return row.error();
  std::vector<RequestAnswer> answers;
  std::uint64_t sum = 0;
  const Status read = database.each(
      "SELECT request_id, content, revision, nodes, seal FROM answer "
      "WHERE scene = ? AND request_id = ?",
      [&](const Row& found) { return read_answer(database, row->key, found, answers, sum); }, scene,
      request_id);
  if (!read) return read.error();
  if (answers.empty()) return std::optional<RequestAnswer>();
  return std::optional(std::move(answers.front()));
}

}  // namespace sightline::server::store
