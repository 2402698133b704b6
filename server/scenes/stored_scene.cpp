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
namespace {

/// An empty scene.
constexpr std::uint64_t kBytesPerScene = 4096;

bool is_patch(const scenegraph::model::Update& update) {
  return std::holds_alternative<scenegraph::model::PatchVertices>(update);
}

}  // namespace

std::uint64_t SceneEvents::subscribe(Listener listener) {
  const std::lock_guard lock(mutex_);
  listeners_.emplace(next_, std::move(listener));
  return next_++;
}

void SceneEvents::unsubscribe(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  listeners_.erase(id);
}

void SceneEvents::notify() noexcept {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, listener] : listeners_) {
    try {
      listener();
    } catch (const std::exception& thrown) {
      spdlog::error("event=listener_failed error={}", thrown.what());
    }
  }
}

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

scenegraph::revision::SceneSummary StoredScene::summary() {
  const auto snapshot = scene_.snapshot();
  {
    const std::lock_guard lock(summary_mutex_);
    if (summarized_revision_ == snapshot->revision()) return summary_;
  }
  const auto summary = scenegraph::revision::summarize(*snapshot);
  const std::lock_guard lock(summary_mutex_);
  summarized_revision_ = summary.revision;
  summary_ = summary;
  return summary;
}

StoredScene::StoredScene(SceneInfo info, exec::MemoryAccount& memory)
    : memory_(memory),
      info_(std::move(info)),
      nodes_(memory.record(exec::Held::kNodes, kBytesPerScene)) {}

Result<scenegraph::Applied> StoredScene::apply(std::vector<scenegraph::model::Update> updates,
                                               exec::Compute& compute,
                                               const scenegraph::ApplyOptions& options) {
  if (removed()) return removed_error();
  auto before = scene_.snapshot();
  const auto needed = needed_by(*before, updates);
  if (!needed) return needed.error();
  if (needed->bytes() > 0) {
    const Status fits = memory_.reclaim(exec::Held::kPatches, needed->bytes());
    if (!fits) return fits.error();
  }
  auto new_nodes = memory_.record(exec::Held::kNodes, needed->nodes);  // until they are in nodes_
  auto unsettled = recent_.retain(before);
  const std::uint64_t names = bytes_of_names(updates);
  Replaced replaced;
  UpdateLog::Entry entry;
  UpdateLog::Updates logged;
  std::vector<RecentRevisions::Kept> dropped;
  const auto prepare = [&](const scenegraph::Applied& next) {
    resolve(updates, next.nodes);
    replaced = bytes_replaced(*before, updates);
    if (unsettled != nullptr &&
        unsettled->shared_trees().static_tree != before->shared_trees().static_tree)
      replaced.bytes += bytes_of(*unsettled->shared_trees().static_tree);
    reserve_patched(updates);
    entry = log_.prepare(std::move(updates));
    logged = entry.updates;
    if (options.before_publish) options.before_publish(next);
  };
  const auto charge = [this](std::uint64_t bytes) { return charge_patch(bytes); };
  // Nothing below throws: what is published is in the log.
  auto applied = scene_.apply(updates, {.expected_revision = options.expected_revision,
                                        .before_publish = prepare,
                                        .charge = charge,
                                        .cancelled = options.cancelled});
  if (applied) {
    auto kept = memory_.record(exec::Held::kLogs, replaced.bytes - replaced.meshes);
    dropped = recent_.account(replaced.bytes, std::move(kept));
    log_.add(std::move(entry));
    remember_patched(*logged);
    const std::size_t nodes = scene_.snapshot()->node_count();
    name_bytes_ =
        nodes == 0 ? 0 : name_bytes_ + names - std::min(name_bytes_ + names, replaced.names);
    nodes_.resize(kBytesPerScene + bytes_of_nodes(nodes) + name_bytes_);
    events_.notify();
  }
  settle_later({std::move(dropped), std::move(unsettled), std::move(before)},
               applied && applied->rebuild_static, compute);
  return applied;
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

/// The meshes that the newest revision has from these updates.
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

std::uint64_t StoredScene::tree_bytes() const {
  const auto snapshot = scene_.snapshot();
  std::uint64_t bytes = bytes_of(*snapshot->shared_trees().static_tree) +
                        bytes_of(*snapshot->shared_trees().dynamic_tree);
  const std::lock_guard lock(patched_mutex_);
  const scenegraph::model::Mesh* last = nullptr;  // several patches of one mesh follow each other
  for (const auto& patched : patched_) {
    const auto mesh = patched.lock();
    if (mesh == nullptr || mesh.get() == last) continue;
    bytes += mesh->tree_bytes();
    last = mesh.get();
  }
  return bytes;
}

/// Freeing old revisions and settling may take long, and no reply waits for them.
void StoredScene::settle_later(Dropped dropped, bool settle, exec::Compute& compute) noexcept {
  try {
    {
      const std::lock_guard lock(dropped_mutex_);
      dropped_.push_back(std::move(dropped));
    }
    compute.enqueue_background([self = shared_from_this(), settle] {
      self->free_dropped();
      // What could not be refused any more when it was recorded.
      static_cast<void>(self->memory_.reclaim(exec::Held::kLogs, 0));
      if (settle) self->scene_.rebuild_static();
    });
  } catch (const std::bad_alloc&) {  // settles after a later update
    free_dropped();
  }
}

void StoredScene::free_dropped() {
  const std::lock_guard freeing(freeing_mutex_);
  std::vector<Dropped> dropped;
  {
    const std::lock_guard lock(dropped_mutex_);
    dropped.swap(dropped_);
  }
}

void StoredScene::remove() {
  removed_.store(true, std::memory_order_release);
  events_.notify();
}

Error StoredScene::removed_error() const { return unknown_scene(info_.name); }

void StoredScene::drop_old_revisions() {
  recent_.drop_all().clear();
  free_dropped();
}

std::uint64_t StoredScene::drop_trees() {
  const auto snapshot = scene_.snapshot();
  const std::uint64_t placed = bytes_of(*snapshot->shared_trees().static_tree) +
                               bytes_of(*snapshot->shared_trees().dynamic_tree);
  return placed + scene_.drop_trees();
}

void StoredScene::drop_old_updates() { log_.drop_all_but(kMinLogged).clear(); }

}  // namespace sightline::server::scenes
