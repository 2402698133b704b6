// The last updates of a scene, as bytes.
#include "server/scenes/update_log.h"

#include <fmt/format.h>

#include <utility>

#include "server/codec/update_parts.h"
#include "server/scenes/applied_updates.h"

namespace sightline::server::scenes {
namespace {

using scenegraph::model::DeleteNode;
using scenegraph::model::PatchVertices;
using scenegraph::model::PutNode;
using scenegraph::model::SetTransforms;

std::uint64_t held_by(const PutNode& put) { return bytes_of_texts(put); }
std::uint64_t held_by(const SetTransforms& set) {
  return set.nodes.size() * sizeof(scenegraph::model::NodeRef) +
         set.parent_from_local.size() * sizeof(scenegraph::model::Affine);
}
std::uint64_t held_by(const DeleteNode&) { return 0; }
std::uint64_t held_by(const PatchVertices& patch) {
  return patch.nodes.size() * sizeof(scenegraph::model::NodeRef) +
         patch.positions.size() * sizeof(accel::geometry::Vec3f);
}

}  // namespace

std::uint64_t bytes_of(const std::vector<scenegraph::model::Update>& updates) {
  using scenegraph::model::Update;
  std::uint64_t bytes = sizeof(std::vector<Update>) + updates.size() * sizeof(Update);
  for (const Update& update : updates)
    bytes += std::visit([](const auto& kind) { return held_by(kind); }, update);
  return bytes;
}

Record UpdateLog::prepare(const std::vector<scenegraph::model::Update>& updates,
                          std::size_t waiting) {
  Record record = records_.keep(codec::encode_parts(updates));
  const std::lock_guard lock(mutex_);
  history_.reserve_more(waiting + 1);
  return record;
}

void UpdateLog::begin_after(std::uint64_t revision) {
  std::vector<Record> dropped;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  dropped = history_.trim_to(0);
  last_ = revision;
}

void UpdateLog::add(Record record) noexcept {
  std::vector<Record> dropped;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  const std::size_t bytes = record.bytes().size();
  history_.append(std::move(record), bytes);
  ++last_;
  dropped = history_.trim();
}

std::vector<Record> UpdateLog::drop_all_but(std::size_t revisions) noexcept {
  const std::lock_guard lock(mutex_);
  return history_.trim_to(revisions);
}

std::uint64_t UpdateLog::last() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

Result<Record> UpdateLog::find(std::uint64_t revision) const {
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
