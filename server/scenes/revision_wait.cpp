// Reads of a revision that may not exist yet.
#include "server/scenes/revision_wait.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace sightline::server::scenes {
namespace {

Error cancelled() { return {Code::kCancelled, "the call was cancelled", "CANCELLED"}; }

}  // namespace

void RevisionWait::read(std::shared_ptr<StoredScene> scene, const v1::Consistency& consistency,
                        Deadline deadline, std::size_t bytes, const exec::Caller& caller,
                        Done done) {
  if (!scene->loaded()) {
    const exec::FlowKey flow = exec::flow_of(caller, scene->info().name);
    return compute_.enqueue_update(
        flow, [this, self = shared_from_this(), scene = std::move(scene), &consistency, deadline,
               bytes, caller, done = std::move(done)]() mutable {
          const Status loaded = scene->load(compute_);
          if (!loaded) return done(loaded.error());
          read(std::move(scene), consistency, deadline, bytes, caller, std::move(done));
        });
  }
  if (consistency.requirement_case() == v1::Consistency::kExactRevision)
    return read_exactly(scene, consistency.exact_revision(), std::move(done));
  if (consistency.requirement_case() != v1::Consistency::kAtLeast) {
    const SceneFollower* follower = scene->follower();
    const Status fresh = follower == nullptr ? Status() : follower->replica().fresh();
    if (!fresh) return done(fresh.error());
    return done(scene->snapshot());
  }
  const auto token = RevisionToken::parse(consistency.at_least());
  if (!token) return done(token.error());
  if (token->incarnation != scene->token(0).incarnation) {
    return done(Error{Code::kInvalidArgument,
                      fmt::format("the token {} is not of this scene {}: it may be of one that was "
                                  "deleted",
                                  token->text(), scene->info().name),
                      "BAD_TOKEN"});
  }
  auto head = scene->snapshot();
  if (head->revision() >= token->revision) return done(std::move(head));
  scene_ = std::move(scene);
  done_ = std::move(done);
  wait(token->revision, deadline, bytes, caller);
}

/// A revision that is not there may have been made by another server.
void RevisionWait::read_exactly(const std::shared_ptr<StoredScene>& scene, std::uint64_t revision,
                                Done done) {
  SceneFollower* const follower = scene->follower();
  if (follower == nullptr || revision <= scene->snapshot()->revision())
    return done(scene->at(revision));
  follower->ask(compute_, [scene, revision, done = std::move(done)](const Status& read) {
    if (!read && revision > scene->snapshot()->revision()) return done(read.error());
    done(scene->at(revision));
  });
}

void RevisionWait::wait(std::uint64_t revision, Deadline deadline, std::size_t bytes,
                        const exec::Caller& caller) {
  revision_ = revision;
  waiting_.store(true);
  std::unique_lock lock(mutex_);
  if (const Status entered = enter(bytes, caller); !entered) {
    ticket_ = {};
    lock.unlock();
    if (waiting_.exchange(false)) std::exchange(done_, nullptr)(entered.error());
    return;
  }
  listener_ = scene_->events().subscribe([this] { on_scene_event(); });
  const auto latest = std::chrono::system_clock::now() + kMaxReadWait;
  // The alarm keeps its callback while it exists, and this object owns the alarm: the callback
  // moves its pointer out.
  alarm_.emplace().Set(std::min(deadline, latest), [self = shared_from_this()](bool) mutable {
    const auto wait = std::move(self);
    wait->end(Error{Code::kUnavailable,
                    fmt::format("revision {} is not there in time", wait->revision_),
                    "REVISION_NOT_THERE"});
  });
  if (cancelled_.load()) end(cancelled());
  on_scene_event();
  if (SceneFollower* const follower = scene_->follower(); follower != nullptr && waiting_.load())
    follower->follow_soon(compute_);
}

Status RevisionWait::enter(std::size_t bytes, const exec::Caller& caller) {
  auto ticket = admission_.admit(caller, 0, bytes);
  if (!ticket) return ticket.error();
  ticket_ = std::move(*ticket);
  return waiting_reads_.enter(this, caller,
                              {.on_stop = [this] { end(waiting_reads_.stopped_error()); }});
}

void RevisionWait::on_scene_event() {
  if (scene_->snapshot()->revision() >= revision_) return end(std::nullopt);
  if (scene_->removed()) end(scene_->removed_error());
}

void RevisionWait::cancel() {
  cancelled_.store(true);
  end(cancelled());
}

/// Continues on a worker: the caller may hold the lock of the events or of the registry, and
/// finish() takes both.
void RevisionWait::end(std::optional<Error> error) {
  if (!waiting_.exchange(false)) return;
  compute_.enqueue_management(
      [self = shared_from_this(), error = std::move(error)] { self->finish(error); });
}

void RevisionWait::finish(const std::optional<Error>& error) {
  std::unique_lock lock(mutex_);
  scene_->events().unsubscribe(listener_);
  waiting_reads_.leave(this);
  if (alarm_) alarm_->Cancel();
  ticket_ = {};
  const auto scene = std::move(scene_);
  const Done done = std::exchange(done_, nullptr);
  lock.unlock();
  if (error) return done(*error);
  done(scene->snapshot());
}

}  // namespace sightline::server::scenes
