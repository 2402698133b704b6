// A scene with its recorded properties, history, write queue and events.
#include "server/scenes/stored_scene.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "server/scenes/applied_updates.h"

namespace sightline::server::scenes {
Error unknown_scene(const std::string& name) {
  return {Code::kNotFound, fmt::format("there is no scene {}", name), "SCENE_NOT_FOUND"};
}

Result<std::shared_ptr<const scenegraph::revision::Snapshot>> StoredScene::at(
    std::uint64_t revision) const {
  auto head = scene_.snapshot();
  if (revision == head->revision()) return head;
  if (auto kept = recent_.find(revision)) return kept;
  return Error{Code::kOutOfRange,
               fmt::format("revision {} is not kept; kept are {} to {}", revision,
                           recent_.oldest_or(head->revision()), head->revision()),
               "REVISION_NOT_KEPT"};
}

Result<scenegraph::revision::SceneSummary> StoredScene::summary() {
  const auto snapshot = scene_.snapshot();
  {
    const std::lock_guard lock(summary_mutex_);
    if (summarized_revision_ == snapshot->revision()) return summary_;
  }
  scenegraph::revision::SceneSummary summary;
  try {
    summary = scenegraph::revision::summarize(*snapshot);
  } catch (const scenegraph::model::MeshUnreadable& thrown) {
    return thrown.error();
  }
  const std::lock_guard lock(summary_mutex_);
  summarized_revision_ = summary.revision;
  summary_ = summary;
  return summary;
}

StoredScene::StoredScene(SceneInfo info, exec::MemoryAccount& memory, KeptScene kept)
    : memory_(memory),
      info_(std::move(info)),
      incarnation_(kept.incarnation),
      number_(kept.number),
      journal_(std::move(kept.journal)),
      nodes_(memory.record(exec::Held::kNodes, bytes_of_scene(0, 0))),
      unread_(kept.unread),
      unread_bytes_(kept.node_bytes),
      loaded_(!kept.unread),
      write_queue_({"", info_.name, info_.name}) {
  if (journal_ == nullptr) return;
  WriteLine::Parts parts{.journal = *journal_,
                         .roll_back = [this] { scene_.drop_unpublished(); },
                         .noted = [this] { advance_soon(); },
                         .owner = [this] { return shared_from_this(); }};
  if (kept.replica != nullptr) {
    follower_.emplace(*this, std::move(kept.replica));
    parts.catch_up = [this] { return follower_->catch_up(); };
  }
  line_.emplace(std::move(parts));
}

StoredScene::~StoredScene() {
  auto kept = recent_.drop_all();
  forget(kept);
  const std::uint64_t bytes = nodes_.bytes();
  nodes_ = {};
  past_.add(*scene_.snapshot(), memory_.record(exec::Held::kRevisions, bytes));
}

KeptScene StoredScene::kept() const {
  return {.journal = journal_,
          .incarnation = incarnation_,
          .unread = unread(),
          .number = number_,
          .replica = follower_ ? follower_->shared_replica() : nullptr,
          .node_bytes = std::max(nodes_.bytes(), loaded() ? 0 : unread_bytes_)};
}

std::optional<std::uint64_t> StoredScene::unread() const {
  if (loaded() || !follower_) return loaded() ? std::nullopt : unread_;
  return std::max(*unread_, follower_->noted());
}

std::uint64_t StoredScene::placed_tree_bytes() const {
  return bytes_of(scene_.snapshot()->shared_trees());
}

std::uint64_t StoredScene::drop_flat_trees() const {
  std::uint64_t bytes = 0;
  for (const scenegraph::instances::Level& level : scene_.snapshot()->shared_trees().levels) {
    const scenegraph::instances::Instances* instances = level.tree->instances_so_far();
    if (instances != nullptr) bytes += instances->drop_flat();
  }
  return bytes;
}

std::vector<std::shared_ptr<const scenegraph::model::Mesh>> StoredScene::patched_meshes() const {
  std::vector<std::shared_ptr<const scenegraph::model::Mesh>> meshes;
  const std::lock_guard lock(patched_mutex_);
  for (const auto& patched : patched_) {
    auto mesh = patched.lock();
    // Several patches of one mesh follow each other.
    if (mesh != nullptr && (meshes.empty() || mesh != meshes.back()))
      meshes.push_back(std::move(mesh));
  }
  return meshes;
}

void StoredScene::free_dropped() {
  const std::lock_guard freeing(freeing_mutex_);
  std::vector<Dropped> dropped;
  {
    const std::lock_guard lock(dropped_mutex_);
    dropped.swap(dropped_);
  }
  dropped.clear();
  release_gone();
}

void StoredScene::release_gone() {
  const auto oldest = recent_.oldest();
  past_.release_gone(oldest != nullptr ? *oldest : *scene_.snapshot());
}

/// What readers have of revisions that are no longer kept still counts. The scene's trees of such a
/// revision count with its readers.
void StoredScene::forget(std::vector<RecentRevisions::Kept>& kept) noexcept {
  for (RecentRevisions::Kept& revision : kept) {
    revision.charge.resize(revision.charge.bytes() -
                           std::min(revision.charge.bytes(), revision.trees));
    past_.add(*revision.snapshot, std::move(revision.charge));
  }
}

void StoredScene::remove() {
  removed_.store(true, std::memory_order_release);
  events_.notify();
}

Error StoredScene::removed_error() const { return unknown_scene(info_.name); }

void StoredScene::drop_old_revisions() {
  auto kept = recent_.drop_all();
  forget(kept);
  kept.clear();
  free_dropped();
}

std::uint64_t StoredScene::drop_trees() {
  const auto snapshot = scene_.snapshot();
  const std::uint64_t placed = bytes_of(snapshot->shared_trees());
  return placed + scene_.drop_trees();
}

void StoredScene::drop_old_updates() { log_.drop_all_but(kMinLogged).clear(); }

}  // namespace sightline::server::scenes
