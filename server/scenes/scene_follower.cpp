// Keeps a scene up to date with what other servers commit to it.
#include "server/scenes/scene_follower.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/scenes/stored_scene.h"

namespace sightline::server::scenes {
namespace {

/// Rounds of waiting for writes of this server. Those of the first round may have been committed
/// before the call, those of the second were not.
constexpr int kRounds = 2;

}  // namespace

void SceneFollower::note(std::uint64_t revision, exec::Compute& compute) {
  {
    const std::lock_guard lock(mutex_);
    const bool was_behind = scene_.loaded() && noted_ > scene_.snapshot()->revision();
    if (revision > noted_) noted_ = revision;
    if (!scene_.loaded() || noted_ <= scene_.snapshot()->revision()) return;
    if (!was_behind) behind_since_ = Clock::now();
  }
  follow_soon(compute);
}

void SceneFollower::follow_soon(exec::Compute& compute) {
  if (!scene_.loaded() || scene_.removed() || following_.exchange(true)) return;
  const Status posted = exec::to_status([&]() -> Status {
    ask(compute, [this](const Status&) { following_ = false; });
    return {};
  });
  if (!posted) following_ = false;  // a later call follows
}

void SceneFollower::ask(exec::Compute& compute, Then then) {
  scene_.write_queue().post(compute, [this, self = scene_.shared_from_this(), &compute,
                                      then = std::move(then)] { when_caught_up(compute, then); });
}

Lag SceneFollower::lag() const {
  const std::lock_guard lock(mutex_);
  if (!scene_.loaded() || scene_.removed()) return {};
  const std::uint64_t revision = scene_.snapshot()->revision();
  if (noted_ <= revision) return {};
  return {noted_ - revision, Clock::now() - behind_since_};
}

Status SceneFollower::catch_up() {
  const std::uint64_t before = scene_.snapshot()->revision();
  Status read = exec::to_status([this] { return read_on(); });
  const std::uint64_t now = scene_.snapshot()->revision();
  replica_->tallies.revisions_followed += now - before;
  if (!read && read.error().reason == "SCENE_NOT_FOUND") {
    scene_.remove();
    return scene_.removed_error();
  }
  log(read);
  return read;
}

Status SceneFollower::read_on() {
  Status read = scene_.read_on();
  if (read || read.error().reason != "REVISION_NOT_KEPT") return read;
  ++replica_->tallies.scenes_reloaded;
  return scene_.read_again();
}

/// Logs once that a scene cannot be followed, however often that is tried, and once that it can.
void SceneFollower::log(const Status& read) {
  if (read.ok() == !failed_) return;
  failed_ = !read.ok();
  if (read) {
    spdlog::info("event=scene_followed scene={} revision={}", scene_.info().name,
                 scene_.snapshot()->revision());
  } else {
    spdlog::warn("event=scene_not_followed scene={} revision={} error={}", scene_.info().name,
                 scene_.snapshot()->revision(), read.error().message);
  }
}

void SceneFollower::when_caught_up(exec::Compute& compute, Then then) {
  scene_.compute_.store(&compute,
                        std::memory_order_release);  // perhaps before the first write here
  wait(compute, std::move(then), kRounds);
}

void SceneFollower::wait(exec::Compute& compute, Then then, int rounds) {
  if (scene_.removed()) return then(scene_.removed_error());
  if (scene_.waiting() == 0) return then(catch_up());
  if (rounds == 0) return then({});  // the commits of its own writes have told
  scene_.when_answered(
      [this, self = scene_.shared_from_this(), &compute, then = std::move(then), rounds] {
        scene_.write_queue().post(
            compute, [this, self, &compute, then, rounds] { wait(compute, then, rounds - 1); });
      });
}

Status SceneFollower::look_up(const std::string& request_id) {
  if (scene_.answers_.knows(request_id)) return {};
  auto kept = scene_.journal_->answer(request_id);
  if (!kept) return kept.error();
  if (*kept) {
    scene_.answers_.retain(scene_.answers_.prepare(request_id, (*kept)->content, (*kept)->applied));
  }
  return {};
}

void SceneFollower::look_up(Producer& producer, exec::Compute& compute, Then then) {
  when_caught_up(compute, [this, &producer, then = std::move(then)](const Status& read) {
    then(read ? exec::to_status([&] { return look_up(producer); }) : read);
  });
}

Status SceneFollower::look_up(Producer& producer) {
  auto kept = scene_.journal_->producer(producer.name);
  if (!kept) return kept.error();
  if (!*kept || (*kept)->last_committed <= producer.last_committed) return {};
  scene_.set_progress(producer, std::move(**kept));
  return {};
}

Result<std::optional<std::vector<scenegraph::model::NodeId>>> SceneFollower::find_kept(
    const std::string& producer, std::uint64_t first_sequence, std::uint64_t batches) {
  using Nodes = std::vector<scenegraph::model::NodeId>;
  auto kept = scene_.journal_->producer(producer);
  if (!kept) return kept.error();
  if (!*kept || (*kept)->last_committed < first_sequence) return std::optional<Nodes>();
  const std::uint64_t last = first_sequence + batches - 1;
  if ((*kept)->last_committed < last) {
    return Error{Code::kUnavailable,
                 fmt::format("batches up to {} of the producer came through another server: open "
                             "the stream again",
                             (*kept)->last_committed),
                 "PRODUCER_MOVED"};
  }
  const auto put = std::ranges::find((*kept)->recent, last, &ProducerBatch::sequence);
  return std::optional(put == (*kept)->recent.end() ? Nodes() : std::move(put->nodes));
}

}  // namespace sightline::server::scenes
