// One batch of updates: decoded on a worker, and applied on its scene's write queue.
#include "server/updates/apply_job.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "server/blobs/digest.h"
#include "server/codec/update_codec.h"
#include "server/exec/rpc_status.h"
#include "server/scenes/write_errors.h"
#include "server/updates/producer_messages.h"

namespace sightline::server::updates {
namespace {

/// Whether the request adds or removes nodes. Such requests are rare, so they are logged at level
/// info.
bool changes_content(const v1::ApplyUpdatesRequest& request) {
  return std::any_of(
      request.updates().begin(), request.updates().end(),
      [](const v1::Update& update) { return update.has_put_node() || update.has_delete_node(); });
}

/// A digest that is the same for every build of the server: scenes keep it. It does not tell
/// whether the request names its scene.
std::uint64_t digest_of(const std::string& scene, const v1::ApplyUpdatesRequest& request) {
  std::string bytes;
  if (request.scene().empty()) {
    // Fields are written in the order of their numbers, and the scene's is the first.
    v1::ApplyUpdatesRequest named;
    named.set_scene(scene);
    named.AppendToString(&bytes);
  }
  request.AppendToString(&bytes);
  blobs::Sha256 sha;
  sha.update(std::as_bytes(std::span(bytes)));
  const blobs::Sha256Sum sum = sha.finish();
  std::uint64_t digest = 0;
  std::memcpy(&digest, sum.data(), sizeof(digest));
  return digest;
}

}  // namespace

Result<std::shared_ptr<const scenegraph::revision::Snapshot>> AppliedAt::snapshot() const {
  auto kept = scene->at(revision);
  if (kept) return kept;
  auto newest = scene->snapshot();
  if (newest->revision() > revision) return newest;
  return Error{Code::kUnavailable,
               fmt::format("another server has made revision {}, and this one has not read it yet",
                           revision),
               "REVISION_NOT_THERE"};
}

Result<std::size_t> bytes_held(const v1::ApplyUpdatesRequest& updates) {
  const Status fits = codec::check_update_count(static_cast<std::size_t>(updates.updates_size()));
  if (!fits) return fits.error();
  return updates.SpaceUsedLong();
}

Status ApplyJob::admit(std::size_t bytes) {
  auto ticket = services_.admission.admit(caller_, 0, bytes);
  if (!ticket) return ticket.error();
  ticket_ = std::move(*ticket);
  return {};
}

void ApplyJob::enqueue(Done done) {
  done_ = std::move(done);
  begin();
}

void ApplyJob::run(Done done) {
  done_ = std::move(done);
  if (const Status ready = exec::to_status([this] { return prepare(); }); !ready) return end(ready);
  const std::shared_ptr<scenes::StoredScene> scene = scene_;  // end() forgets it
  scene->write_queue().run_or_post(services_.compute, [this] { run_on_queue(); });
}

void ApplyJob::begin() {
  services_.compute.enqueue_update(exec::flow_of(caller_, scene_name_), [this] {
    if (const Status ready = exec::to_status([this] { return prepare(); }); !ready)
      return end(ready);
    scene_->write_queue().post(services_.compute, [this] { run_on_queue(); });
  });
}

Status ApplyJob::prepare() {
  auto scene = services_.find(scene_name_);
  if (!scene) return scene.error();
  if (Status good = scenes::check_request_id(request_.request_id()); !good) return good;
  scene_ = std::move(*scene);
  if (Status loaded = scene_->load(services_.compute); !loaded) return loaded;
  // A decode error is reported later: a repeated request gets its first answer instead.
  updates_.emplace(codec::decode_updates(request_.updates(), services_.blobs));
  if (!request_.request_id().empty()) content_ = digest_of(scene_name_, request_);
  return {};
}

void ApplyJob::run_on_queue() {
  const Status begun = exec::to_status([this] { return apply(); });
  if (!begun) not_applied(begun);  // else answered() ends the job, perhaps already
}

/// Where other servers write, too, the request is refused only once it is known what they have
/// committed, and that none of them has got it before.
void ApplyJob::not_applied(const Status& why) {
  scenes::SceneFollower* const follower = scene_->follower();
  if (follower == nullptr || scene_->removed() || caught_up_ ||
      scenes::says_nothing_of_the_batch(why.error()))
    return refuse(why);
  caught_up_ = true;
  follower->when_caught_up(services_.compute, [this, follower](const Status& read) {
    const std::string& id = request_.request_id();
    const Status known =
        exec::to_status([&] { return !read || id.empty() ? read : follower->look_up(id); });
    if (!known) return refuse(known);
    run_on_queue();
  });
}

/// Another server may have made another scene in place of this one: asks once.
void ApplyJob::refuse(const Status& why) {
  const bool gone = scene_->follower() != nullptr && scene_->removed();
  if (!gone || std::exchange(looked_up_, true)) return end(why);
  caught_up_ = false;
  begin();
}

Status ApplyJob::apply() {
  if (cancelled_.load(std::memory_order_relaxed))
    return Error{Code::kCancelled, "the call was cancelled", "CANCELLED"};
  // answered() may end the job, and with it this object, before the members of the scene return.
  const std::shared_ptr<scenes::StoredScene> scene = scene_;
  const std::string id = request_.request_id();
  if (!id.empty()) {
    const auto repeat = scene->find_earlier(
        id, content_,
        [this](const scenegraph::Applied& earlier, const Result<scenes::Durability>& durability) {
          encode_applied(earlier);
          reply_.set_replayed(true);
          answered(durability);
        });
    if (!repeat) return repeat.error();
    if (*repeat) return {};
  }
  if (!*updates_) return updates_->error();
  const auto encode = [this](const scenegraph::Applied& next) { encode_applied(next); };
  const auto applied = scene->try_apply(
      **updates_, services_.compute,
      {.expected_revision = expected(), .before_publish = encode, .cancelled = &cancelled_},
      {.request_id = id,
       .content = content_,
       .answer = [this](const Result<scenes::Durability>& durability) { answered(durability); },
       .repeated =
           [this](const scenegraph::Applied& earlier) {
             encode_applied(earlier);
             reply_.set_replayed(true);
           }});
  return applied ? Status() : Status(applied.error());
}

/// Runs on the write queue, when the updates are kept, or cannot be.
void ApplyJob::answered(const Result<scenes::Durability>& durability) {
  if (!durability) return refuse(durability.error());
  reply_.set_durability(encode_durability(*durability));
  log();
  end({});
}

std::optional<std::uint64_t> ApplyJob::expected() const {
  if (!request_.has_expected_revision()) return std::nullopt;
  return request_.expected_revision();
}

void ApplyJob::encode_applied(const scenegraph::Applied& applied) {
  revision_ = applied.revision;
  encode_revision(scene_->token(applied.revision), *reply_.mutable_revision());
  reply_.mutable_nodes()->Assign(applied.nodes.begin(), applied.nodes.end());
}

void ApplyJob::log() const {
  if (reply_.replayed()) return;
  spdlog::log(changes_content(request_) ? spdlog::level::info : spdlog::level::debug,
              "event=scene_updated scene={} revision={} updates={}{}", scene_->info().name,
              reply_.revision().revision(), request_.updates_size(), exec::call_ids_of(context_));
}

void ApplyJob::end(const Status& status) {
  updates_.reset();
  ticket_ = {};
  AppliedAt at{std::exchange(scene_, nullptr), revision_};
  const Done done = std::exchange(done_, nullptr);  // may destroy this
  done(status ? Result<AppliedAt>(std::move(at)) : Result<AppliedAt>(status.error()));
}

}  // namespace sightline::server::updates
