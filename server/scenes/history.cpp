// What a scene keeps of its past: recent revisions, and the updates that made them.
#include "server/scenes/history.h"

#include <fmt/format.h>

#include <utility>

namespace sightline::server::scenes {
namespace {

using scenegraph::model::DeleteNode;
using scenegraph::model::PatchVertices;
using scenegraph::model::PutNode;
using scenegraph::model::SetTransforms;

std::uint64_t held_by(const PutNode& put) { return put.name.size() + put.mesh_digest.size(); }
std::uint64_t held_by(const SetTransforms& set) {
  return set.nodes.size() * sizeof(scenegraph::model::NodeRef) +
         set.parent_from_local.size() * sizeof(scenegraph::model::Affine);
}
std::uint64_t held_by(const DeleteNode&) { return 0; }
std::uint64_t held_by(const PatchVertices& patch) {
  return patch.nodes.size() * sizeof(scenegraph::model::NodeRef) +
         patch.positions.size() * sizeof(accel::geometry::Vec3f);
}

struct ChargedUpdates {
  std::vector<scenegraph::model::Update> updates;
  exec::MemoryAccount::Charge charge;
};

}  // namespace

void RecentRevisions::reserve_more(std::size_t entries) {
  const std::lock_guard lock(mutex_);
  history_.reserve_more(entries);
}

RecentRevisions::SnapshotPointer RecentRevisions::retain(SnapshotPointer snapshot) {
  const std::lock_guard lock(mutex_);
  if (!history_.empty() && history_.newest().snapshot->revision() == snapshot->revision()) {
    history_.newest().snapshot.swap(snapshot);
    return snapshot;
  }
  history_.append({std::move(snapshot), {}});
  return nullptr;
}

std::vector<RecentRevisions::Kept> RecentRevisions::account(std::uint64_t bytes,
                                                            Charge charge) noexcept {
  const std::lock_guard lock(mutex_);
  if (history_.empty()) return {};  // drop_all() came in between
  history_.add_weight(bytes);
  history_.newest().charge = std::move(charge);
  return history_.trim();
}

RecentRevisions::SnapshotPointer RecentRevisions::find(std::uint64_t revision) const {
  const std::lock_guard lock(mutex_);
  if (history_.empty()) return nullptr;
  const std::uint64_t oldest = history_.oldest().snapshot->revision();
  if (revision < oldest || revision - oldest >= history_.size()) return nullptr;
  return history_[revision - oldest].snapshot;
}

std::uint64_t RecentRevisions::oldest_or(std::uint64_t head) const {
  const std::lock_guard lock(mutex_);
  return history_.empty() ? head : history_.oldest().snapshot->revision();
}

std::vector<RecentRevisions::Kept> RecentRevisions::drop_all() noexcept {
  const std::lock_guard lock(mutex_);
  return history_.trim_to(0);
}

std::uint64_t bytes_of(const std::vector<scenegraph::model::Update>& updates) {
  using scenegraph::model::Update;
  std::uint64_t bytes = sizeof(std::vector<Update>) + updates.size() * sizeof(Update);
  for (const Update& update : updates)
    bytes += std::visit([](const auto& kind) { return held_by(kind); }, update);
  return bytes;
}

UpdateLog::Entry UpdateLog::prepare(std::vector<scenegraph::model::Update> updates,
                                    std::size_t waiting) {
  const std::uint64_t bytes = bytes_of(updates);
  const auto charged = std::make_shared<const ChargedUpdates>(
      ChargedUpdates{std::move(updates), memory_.record(exec::Held::kLogs, bytes)});
  Entry entry{Updates(charged, &charged->updates), bytes};
  const std::lock_guard lock(mutex_);
  history_.reserve_more(waiting + 1);
  return entry;
}

void UpdateLog::begin_after(std::uint64_t revision) {
  std::vector<Updates> dropped;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  dropped = history_.trim_to(0);
  last_ = revision;
}

void UpdateLog::add(Entry entry) noexcept {
  std::vector<Updates> dropped;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  history_.append(std::move(entry.updates), entry.bytes);
  ++last_;
  dropped = history_.trim();
}

std::vector<UpdateLog::Updates> UpdateLog::drop_all_but(std::size_t revisions) noexcept {
  const std::lock_guard lock(mutex_);
  return history_.trim_to(revisions);
}

std::uint64_t UpdateLog::last() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

Result<UpdateLog::Updates> UpdateLog::find(std::uint64_t revision) const {
  const std::lock_guard lock(mutex_);
  const std::uint64_t first = last_ - history_.size() + 1;
  if (revision >= first && revision <= last_) return history_[revision - first];
  return Error{Code::kOutOfRange,
               fmt::format("what made revision {} is not kept; kept are {} to {}: read the scene, "
                           "then watch from its revision",
                           revision, first, last_),
               "REVISION_NOT_KEPT"};
}

}  // namespace sightline::server::scenes
