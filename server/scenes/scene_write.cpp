// Writes of a scene: applied at its head, kept in its journal, then published.
#include <algorithm>
#include <cassert>
#include <future>
#include <new>
#include <set>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/scenes/applied_updates.h"
#include "server/scenes/stored_scene.h"

namespace sightline::server::scenes {
namespace {

bool is_patch(const scenegraph::model::Update& update) {
  return std::holds_alternative<scenegraph::model::PatchVertices>(update);
}

std::vector<std::string> mesh_digests(const std::vector<scenegraph::model::Update>& updates) {
  std::set<std::string> digests;
  for (const scenegraph::model::Update& update : updates) {
    const auto* put = std::get_if<scenegraph::model::PutNode>(&update);
    if (put != nullptr && !put->mesh_digest.empty()) digests.insert(put->mesh_digest);
  }
  return {digests.begin(), digests.end()};
}

}  // namespace

/// What is made of an update before it is published.
struct StoredScene::Publication {
  bool revises = true;  ///< Makes a revision.
  bool merge_trees = false;
  exec::MemoryAccount::Charge held;  ///< Held until the revision counts its bytes.
  Replaced replaced;
  std::uint64_t names = 0;
  std::vector<scenegraph::model::Update> updates;
  Record record;  // the updates
  RequestAnswers::Entry answer;
  Producer* producer = nullptr;
  std::vector<Producer::Put> puts;
};

Result<scenegraph::Applied> StoredScene::apply(std::vector<scenegraph::model::Update> updates,
                                               exec::Compute& compute,
                                               const scenegraph::ApplyOptions& options,
                                               const SceneWrite& write) {
  return try_apply(updates, compute, options, write);
}

Result<scenegraph::Applied> StoredScene::try_apply(std::vector<scenegraph::model::Update>& updates,
                                                   exec::Compute& compute,
                                                   const scenegraph::ApplyOptions& options,
                                                   const SceneWrite& write) {
  if (const Status ready = begin_write(compute); !ready) return ready.error();
  return apply_at_head(updates, options, write, line_ ? &*line_ : nullptr);
}

Result<scenegraph::Applied> StoredScene::replay(std::vector<scenegraph::model::Update> updates) {
  return apply_at_head(updates, {}, {}, nullptr);
}

/// Applies a batch. Without a line, the revision is published at once.
Result<scenegraph::Applied> StoredScene::apply_at_head(
    std::vector<scenegraph::model::Update>& updates, const scenegraph::ApplyOptions& options,
    const SceneWrite& write, WriteLine* line) {
  const auto before = scene_.head();
  const auto needed = needed_by(*before, updates);
  if (!needed) return needed.error();
  const Replaced replaced = bytes_replaced(*before, updates);
  // While the old revision has readers, both are held.
  const std::uint64_t kept = replaced.bytes - replaced.meshes;
  auto publication = std::make_shared<Publication>();
  publication->replaced = replaced;
  if (needed->bytes() > 0) {
    const Status fits = memory_.reclaim(exec::Held::kPatches, needed->bytes() + kept,
                                        bytes_of_scene(before->node_count(), 0));
    if (!fits) return fits.error();
    auto held = memory_.charge(exec::Held::kNodes, needed->nodes + kept);
    if (!held) return held.error();
    publication->held = std::move(*held);
  } else {
    publication->held = memory_.record(exec::Held::kNodes, kept);
  }
  publication->names = bytes_of_names(updates);
  WriteLine::Prepared item;
  const auto prepare = [&](const scenegraph::Applied& next) {
    if (line != nullptr) {
      JournalEntry entry = entry_of(write, next);
      entry.updates = journal_->encode(updates, next.nodes);
      entry.mesh_digests = mesh_digests(updates);
      item = line->prepare(line_write(std::move(entry), options, write, publication));
    }
    prepare_publication(*publication, write, next, updates);
    if (options.before_publish) options.before_publish(next);
  };
  const auto charge = [this](std::uint64_t bytes) { return charge_patch(bytes); };
  // Nothing below throws: what is applied is published or rolled back.
  auto applied = scene_.apply(updates, {.expected_revision = options.expected_revision,
                                        .before_publish = prepare,
                                        .charge = charge,
                                        .cancelled = options.cancelled,
                                        .publish = false});
  if (applied) finish_write(line, std::move(item), *publication, write);
  return applied;
}

Status StoredScene::record_rejected(exec::Compute& compute, const SceneWrite& write) {
  if (Status ready = begin_write(compute); !ready) return ready;
  reject_at_head(write);
  return {};
}

void StoredScene::reject_at_head(const SceneWrite& write) {
  auto publication = std::make_shared<Publication>();
  publication->revises = false;
  scenegraph::Applied next;  // prepared like a batch that makes the next revision
  next.revision = scene_.head()->revision() + 1;
  prepare_producer(*publication, write, next);
  WriteLine* const line = line_ ? &*line_ : nullptr;
  WriteLine::Prepared item;
  if (line != nullptr) {
    item = line->prepare(line_write(entry_of(write, next), {}, write, publication));
  }
  finish_write(line, std::move(item), *publication, write);
}

Status StoredScene::begin_write(exec::Compute& compute) {
  if (removed()) return removed_error();
  compute_.store(&compute, std::memory_order_release);
  return line_ ? line_->ready() : Status();
}

JournalEntry StoredScene::entry_of(const SceneWrite& write, const scenegraph::Applied& next) {
  JournalEntry entry;
  entry.expected = next.revision - 1;
  entry.nodes = next.nodes;
  entry.request_id = write.request_id;
  entry.content = write.content;
  if (write.producer == nullptr) return entry;
  entry.producer = write.producer->name;
  for (std::uint64_t i = 0; i < write.batches; ++i)
    entry.batches.push_back({write.first_sequence + i, next.nodes});
  return entry;
}

WriteLine::Write StoredScene::line_write(JournalEntry entry,
                                         const scenegraph::ApplyOptions& options,
                                         const SceneWrite& write,
                                         const std::shared_ptr<Publication>& publication) {
  WriteLine::Write line_write{.entry = std::move(entry),
                              .relaxed = write.relaxed && !follower_,
                              .publish = [this, publication] { publish(*publication); },
                              .answer = write.answer};
  if (follower_) {
    SceneWrite retried = write;
    retried.answer = nullptr;
    // It goes on when its caller has gone: others may have joined it, or wait behind it.
    scenegraph::ApplyOptions uncancelled = options;
    uncancelled.cancelled = nullptr;
    line_write.retry = [this, options = std::move(uncancelled), retried = std::move(retried)](
                           const JournalEntry& lost, const WriteLine::Answer& answer) {
      return retry_after_conflict(lost, options, retried, answer);
    };
  }
  return line_write;
}

void StoredScene::prepare_publication(Publication& publication, const SceneWrite& write,
                                      const scenegraph::Applied& next,
                                      std::vector<scenegraph::model::Update>& updates) {
  resolve(updates, next.nodes);
  publication.merge_trees = next.merge_trees;
  reserve_patched(updates);
  recent_.reserve_more(waiting() + 1);
  publication.record = log_.prepare(updates, waiting());
  publication.updates = std::move(updates);
  if (!write.request_id.empty()) {
    publication.answer = answers_.prepare(write.request_id, write.content, next, waiting());
  }
  prepare_producer(publication, write, next);
}

void StoredScene::prepare_producer(Publication& publication, const SceneWrite& write,
                                   const scenegraph::Applied& next) {
  publication.producer = write.producer;
  if (write.producer == nullptr) return;
  for (std::uint64_t i = 0; i < write.batches; ++i) {
    publication.puts.push_back(
        {write.first_sequence + i, next.nodes,
         memory_.record(exec::Held::kLogs, next.nodes.size() * sizeof(scenegraph::model::NodeId))});
  }
  // A write that waits is of at most a window of batches.
  write.producer->put.reserve_more(write.batches + kPutsKept * waiting());
}

// NOLINTNEXTLINE(bugprone-exception-escape): memory was reserved for all that it does
void StoredScene::finish_write(WriteLine* line, WriteLine::Prepared item, Publication& publication,
                               const SceneWrite& write) noexcept {
  if (line != nullptr) return line->add(std::move(item));
  publish(publication);
  if (write.answer) write.answer(Durability::kRelaxed);
}

/// Makes what was applied next visible.
// NOLINTNEXTLINE(bugprone-exception-escape): memory was reserved for all that it does
void StoredScene::publish(Publication& publication) noexcept {
  for (Producer::Put& put : publication.puts) publication.producer->commit(std::move(put));
  if (!publication.revises) return;
  auto before = scene_.snapshot();
  auto superseded = recent_.retain(before);
  const Replaced& replaced = publication.replaced;
  std::uint64_t trees = 0;
  if (superseded != nullptr) trees += bytes_of_replaced_trees(*superseded, *before);
  scene_.publish_next();
  trees += bytes_of_replaced_trees(*before, *scene_.snapshot());
  auto kept = memory_.record(exec::Held::kRevisions, replaced.bytes - replaced.meshes + trees);
  auto dropped = recent_.account(replaced.bytes + trees, std::move(kept), trees);
  forget(dropped);
  log_.add(std::move(publication.record));
  remember_patched(publication.updates);
  const std::size_t nodes = scene_.snapshot()->node_count();
  const std::uint64_t names = name_bytes_ + publication.names;
  name_bytes_ = nodes == 0 ? 0 : names - std::min(names, replaced.names);
  nodes_.resize(bytes_of_scene(nodes, name_bytes_));
  publication.held = {};
  answers_.retain(std::move(publication.answer));
  events_.notify();
  clean_up_later({std::move(dropped), std::move(superseded), std::move(before)},
                 publication.merge_trees);
  if (journal_ != nullptr && loaded())
    journal_->published(scene_.state(), recent_.oldest_or(scene_.snapshot()->revision()));
}

/// Advances the line soon. Called after the journal has reported the outcome of a write.
void StoredScene::advance_soon() noexcept {
  if (advance_posted_.exchange(true)) return;
  exec::Compute& compute = *compute_.load(std::memory_order_acquire);
  const Status posted = exec::to_status([&]() -> Status {
    write_queue_.post(compute, [self = shared_from_this()] {
      self->advance_posted_ = false;
      self->line_->advance();
    });
    return {};
  });
  if (!posted) advance_posted_ = false;  // a later call advances the line
}

void StoredScene::retry_writes() {
  if (!line_ || !line_->stalled()) return;
  write_queue_.post(*compute_.load(std::memory_order_acquire),
                    [self = shared_from_this()] { static_cast<void>(self->line_->ready()); });
}

void StoredScene::flush(Clock::time_point until) {
  exec::Compute* const compute = compute_.load(std::memory_order_acquire);
  if (!line_ || compute == nullptr) return;
  const auto kept = std::make_shared<std::promise<void>>();
  write_queue_.post(*compute, [self = shared_from_this(), kept] {
    self->when_committed([kept](const Status&) { kept->set_value(); });
  });
  kept->get_future().wait_until(until);
}

Result<bool> StoredScene::find_earlier(const std::string& request_id, std::uint64_t content,
                                       const Repeat& answer) {
  const auto known = answers_.find(request_id, content);
  if (!known) return known.error();
  if (*known) {
    answer(**known, is_kept() ? Durability::kCommitted : Durability::kRelaxed);
    return true;
  }
  const JournalEntry* waiting = line_ ? line_->find(request_id) : nullptr;
  if (waiting == nullptr) return false;
  if (waiting->content != content) return request_id_reused(request_id, waiting->expected + 1);
  line_->join(*waiting, [this, request_id, content, answer](const Result<Durability>& kept) {
    if (!kept) return answer({}, kept);
    // The answer is looked up now: the write may have been retried since.
    const auto made = answers_.find(request_id, content);
    assert(made && *made);
    answer(**made, kept);
  });
  return true;
}

void StoredScene::when_answered(std::function<void()> then) {
  if (!line_) return then();
  line_->when_answered(std::move(then));
}

void StoredScene::when_committed(WriteLine::Committed then) {
  if (!line_) return then({});
  line_->when_committed(std::move(then));
}

Result<std::shared_ptr<const void>> StoredScene::charge_patch(std::uint64_t bytes) {
  auto charge = memory_.charge(exec::Held::kPatches, bytes);
  if (!charge) return charge.error();
  return std::shared_ptr<const void>(
      std::make_shared<exec::MemoryAccount::Charge>(std::move(*charge)));
}

/// Makes room for remember_patched().
void StoredScene::reserve_patched(const std::vector<scenegraph::model::Update>& updates) {
  const auto patches = static_cast<std::size_t>(std::ranges::count_if(updates, is_patch));
  if (patches == 0) return;
  const std::lock_guard lock(patched_mutex_);
  std::erase_if(patched_, [](const auto& mesh) { return mesh.expired(); });
  patched_.reserve(patched_.size() + patches);
}

/// Remembers the meshes that the newest revision has from these updates.
void StoredScene::remember_patched(const std::vector<scenegraph::model::Update>& updates) {
  const auto snapshot = scene_.snapshot();
  const std::lock_guard lock(patched_mutex_);
  for (const scenegraph::model::Update& update : updates) {
    if (!is_patch(update)) continue;
    const auto& patch = std::get<scenegraph::model::PatchVertices>(update);
    const scenegraph::model::Node* node =
        snapshot->find(static_cast<scenegraph::model::NodeId>(patch.nodes.front()));
    if (node != nullptr && node->patched) patched_.emplace_back(node->mesh);
  }
}

/// Freeing old revisions and merging trees may take long, and no reply waits for them. A scene may
/// be unloaded before.
void StoredScene::clean_up_later(Dropped dropped, bool merge_trees) noexcept {
  try {
    {
      const std::lock_guard lock(dropped_mutex_);
      dropped_.push_back(std::move(dropped));
    }
    compute_.load(std::memory_order_acquire)
        ->enqueue_background([scene = weak_from_this(), merge_trees] {
          const auto self = scene.lock();
          if (self == nullptr) return;
          self->free_dropped();
          // Makes room for what was recorded when it could not be refused any more.
          static_cast<void>(self->memory_.reclaim(
              exec::Held::kLogs, 0, bytes_of_scene(self->snapshot()->node_count(), 0)));
          if (merge_trees) self->scene_.merge_trees();
        });
  } catch (const std::bad_alloc&) {  // a later update does it
    free_dropped();
  }
}

}  // namespace sightline::server::scenes
