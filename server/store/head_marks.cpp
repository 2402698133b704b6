// How far each scene had got, kept beside the database: so it shows when the database goes back.
#include "server/store/head_marks.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace sightline::server::store {
namespace {

/// Numbers in a slot; the rest of its bytes are zero. No slot lies in two sectors of a disk.
constexpr std::size_t kNumbers = 5;
constexpr std::size_t kSlotBytes = 64;
using Slot = std::array<std::uint64_t, kSlotBytes / sizeof(std::uint64_t)>;

std::uint64_t seal_mark(const Mark& mark) {
  return to_sum(Seal(RowKind::kMark, mark.scene).add(mark.edits).add(mark.revision).value());
}

Slot to_slot(const Mark& mark) {
  if (mark.scene.id == 0) return {};
  return {static_cast<std::uint64_t>(mark.scene.id), mark.scene.uid, mark.edits, mark.revision,
          seal_mark(mark)};
}

Mark to_mark(const Slot& slot) {
  return {{static_cast<SceneId>(slot[0]), slot[1]}, slot[2], slot[3]};
}

}  // namespace

std::filesystem::path marks_file(const std::filesystem::path& directory) {
  return directory / "heads";
}

Result<HeadMarks> HeadMarks::open(FileSystem& files, const std::filesystem::path& path) {
  HeadMarks marks(files, path);
  marks.found_ = files.exists(path);
  if (!marks.found_) return marks;
  const auto mapped = files.map(path);
  if (!mapped) return mapped.error();
  marks.parse((*mapped)->bytes());
  return marks;
}

void HeadMarks::parse(std::span<const std::byte> bytes) {
  end_ = (bytes.size() + kSlotBytes - 1) / kSlotBytes;
  for (std::size_t i = 0; i < end_; ++i) {
    Slot slot{};
    const auto part =
        bytes.subspan(i * kSlotBytes, std::min(kSlotBytes, bytes.size() - i * kSlotBytes));
    std::memcpy(slot.data(), part.data(), part.size());
    const Mark mark = to_mark(slot);
    if (slot == Slot{}) {
      free_.push_back(i);
    } else if (slot == to_slot(mark) && marks_.emplace(mark.scene.id, mark).second) {
      slots_.emplace(mark.scene.id, i);
    } else {
      ++damaged_;
      free_.push_back(i);
    }
  }
}

Status HeadMarks::open_file() {
  if (file_) return {};
  auto file = files_->open(path_);
  if (!file) return file.error();
  if (Status named = files_->sync_directory(path_.parent_path()); !named) return named;
  file_ = std::move(*file);
  return {};
}

Status HeadMarks::sync_file() {
  Status synced = open_file();
  if (synced) synced = files_->sync(file_, path_);
  behind_ = behind_ || !synced;
  return synced;
}

Status HeadMarks::write_slot(std::size_t slot, const Mark& mark) {
  const Slot numbers = to_slot(mark);
  Status written = open_file();
  if (written)
    written = files_->write_at(file_, std::as_bytes(std::span(numbers)), slot * kSlotBytes, path_);
  behind_ = behind_ || !written;
  return written;
}

Status HeadMarks::set(const Mark& mark) {
  marks_[mark.scene.id] = mark;
  const auto known = slots_.find(mark.scene.id);
  if (known != slots_.end()) return write_slot(known->second, mark);
  std::size_t slot = end_;
  if (free_.empty()) {
    ++end_;
  } else {
    slot = free_.back();
    free_.pop_back();
  }
  slots_.emplace(mark.scene.id, slot);
  if (Status written = write_slot(slot, mark); !written) return written;
  return sync_file();
}

Status HeadMarks::erase(SceneId scene) {
  const auto known = slots_.find(scene);
  if (known == slots_.end()) return {};
  const std::size_t slot = known->second;
  slots_.erase(known);
  marks_.erase(scene);
  free_.push_back(slot);
  if (Status written = write_slot(slot, {}); !written) return written;
  return sync_file();
}

Status HeadMarks::sync() {
  if (std::exchange(behind_, false)) {
    for (const std::size_t slot : free_) {
      if (Status written = write_slot(slot, {}); !written) return written;
    }
    for (const auto& [scene, slot] : slots_) {
      if (Status written = write_slot(slot, marks_[scene]); !written) return written;
    }
  }
  return sync_file();
}

}  // namespace sightline::server::store
