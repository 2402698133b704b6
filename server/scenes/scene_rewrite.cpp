// Writes of a scene that conflict with those of another server: applied again on top of what it
// committed.
#include <fmt/format.h>

#include <utility>

#include "server/scenes/stored_scene.h"
#include "server/scenes/write_errors.h"

namespace sightline::server::scenes {
namespace {

Error contended(int tries) {
  return {
      Code::kUnavailable,
      fmt::format("other servers have committed to the scene first, {} times: retry later", tries),
      "WRITE_CONTENDED"};
}

}  // namespace

/// What cannot be decided without the client is an error, which ends a producer's stream.
Status StoredScene::retry_after_conflict(const JournalEntry& entry,
                                         const scenegraph::ApplyOptions& options,
                                         const SceneWrite& write, const WriteLine::Answer& answer) {
  if (follower_->replica().stopped())
    return Error{Code::kUnavailable, "the server is stopping", "STOPPING"};
  Replica::Tallies& tallies = follower_->replica().tallies;
  if (write.tries + 1 >= kMaxTries) {
    ++tallies.writes_failed;
    return contended(write.tries + 1);
  }
  const auto repeat = find_repeat(write, answer);
  if (!repeat) return repeat.error();
  if (*repeat) return {};
  ++tallies.writes_repeated;
  SceneWrite next = write;
  next.answer = answer;
  ++next.tries;
  if (!entry.updates) {
    reject_at_head(next);
    return {};
  }
  auto updates = journal_->decode(*entry.updates);
  if (!updates) return updates.error();
  const auto applied = apply_at_head(*updates, options, next, &*line_);
  if (applied) return {};
  if (says_nothing_of_the_batch(applied.error())) return applied.error();
  if (write.producer == nullptr) {
    answer(applied.error());
    return {};
  }
  if (write.batches > 1) return contended(next.tries);  // its parts may be valid
  write.rejected(applied.error());
  reject_at_head(next);
  return {};
}

/// Whether the write is kept because another server has got it, too. If so, answers it.
Result<bool> StoredScene::find_repeat(const SceneWrite& write, const WriteLine::Answer& answer) {
  if (!write.request_id.empty()) {
    if (const Status read = follower_->look_up(write.request_id); !read) return read.error();
    const auto known = answers_.find(write.request_id, write.content);
    if (!known) {
      answer(known.error());
      return true;
    }
    if (!*known) return false;
    write.repeated(**known);
    answer(Durability::kCommitted);
    return true;
  }
  if (write.producer == nullptr) return false;
  auto nodes = follower_->find_kept(write.producer->name, write.first_sequence, write.batches);
  if (!nodes) return nodes.error();
  if (!*nodes) return false;
  if (const Status read = follower_->look_up(*write.producer); !read) return read.error();
  write.repeated({scene_.snapshot()->revision(), std::move(**nodes)});
  answer(Durability::kCommitted);
  return true;
}

}  // namespace sightline::server::scenes
