// Meshes by the digest of their bytes, and uploads in progress.
#include "server/blobs/blob_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace sightline::server::blobs {
namespace {

Error dropped(const BlobDigest& digest) {
  return {Code::kAborted,
          fmt::format("the upload of {} was idle and was dropped to make room; start again at 0",
                      digest.text()),
          "UPLOAD_DROPPED"};
}

}  // namespace

Status Upload::append(std::uint64_t offset, std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  if (!content_) return dropped(digest_);
  if (offset != content_->reader.received()) {
    return Error{Code::kOutOfRange,
                 fmt::format("the upload of {} continues at byte {}, not {}", digest_.text(),
                             content_->reader.received(), offset),
                 "WRONG_OFFSET"};
  }
  if (Status taken = content_->reader.append(bytes); !taken) return taken;
  content_->sum.update(bytes);
  committed_ = content_->reader.received();
  if (committed_ - progress_ >= kUploadProgress || committed_ == digest_.size) {
    progress_ = committed_;
    last_progress_ = Clock::now();
  }
  return {};
}

Result<std::shared_ptr<const scenegraph::model::Mesh>> Upload::finish() {
  const std::lock_guard lock(mutex_);
  if (!content_) return dropped(digest_);
  // Missing bytes have their own error, so the checksum is compared only if all have arrived.
  if (content_->reader.received() == digest_.size && content_->sum.finish() != digest_.sum) {
    return Error{Code::kDataLoss,
                 fmt::format("the bytes that arrived are not those of {}", digest_.text()),
                 "DIGEST_MISMATCH"};
  }
  return content_->reader.finish();
}

bool Upload::drop() {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return false;
  content_.reset();
  return true;
}

BlobStore::MeshPointer BlobStore::find(const BlobDigest& digest) const {
  const std::lock_guard lock(mutex_);
  const auto found = meshes_.find(digest);
  return found == meshes_.end() ? nullptr : found->second.mesh;
}

Result<std::shared_ptr<Upload>> BlobStore::begin(const BlobDigest& digest, std::uint64_t offset,
                                                 exec::Quotas::Use stored) {
  if (digest.size < kMeshBlobHeader) {
    return Error{Code::kInvalidArgument,
                 fmt::format("a blob of {} bytes is shorter than the {} bytes of a mesh's header",
                             digest.size, kMeshBlobHeader),
                 "BAD_MESH_BLOB"};
  }
  {
    const std::lock_guard lock(mutex_);
    if (offset != 0) return resume(digest, offset);
    if (const auto old = set_aside_of(digest); old != pending_.end()) erase(old->upload.get());
  }
  auto charge = memory_.reclaim_and_charge(exec::Held::kUploads, digest.size);
  if (!charge) return charge.error();
  auto upload = std::make_shared<Upload>(digest);
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (pending_.size() < limits_.uploads) {
        pending_.push_back({upload, std::move(*charge), std::move(stored), false});
        return upload;
      }
    }
    if (drop_set_aside() || drop_idle()) continue;
    return Error{Code::kResourceExhausted,
                 fmt::format("{} uploads are under way, the limit is {}; retry later",
                             limits_.uploads, limits_.uploads),
                 "TOO_MANY_UPLOADS"};
  }
}

Result<std::shared_ptr<Upload>> BlobStore::resume(const BlobDigest& digest, std::uint64_t offset) {
  const auto found = set_aside_of(digest);
  const std::uint64_t committed = found == pending_.end() ? 0 : found->upload->committed();
  if (committed != offset) {
    return Error{Code::kOutOfRange,
                 fmt::format("the upload of {} continues at byte {}, not {}", digest.text(),
                             committed, offset),
                 "WRONG_OFFSET"};
  }
  pending_.splice(pending_.end(), pending_, found);
  pending_.back().set_aside = false;
  return pending_.back().upload;
}

Result<BlobStore::MeshPointer> BlobStore::complete(const std::shared_ptr<Upload>& upload) {
  Result<MeshPointer> made = upload->finish();
  exec::Quotas::Use stored;
  const std::lock_guard lock(mutex_);
  const auto pending = std::find_if(pending_.begin(), pending_.end(),
                                    [&](const Pending& one) { return one.upload == upload; });
  if (pending != pending_.end()) stored = std::move(pending->stored);
  erase(upload.get());
  if (!made) return made;
  const auto [kept, is_new] = meshes_.try_emplace(upload->digest());
  if (is_new) {
    kept->second = {*made, memory_.record(exec::Held::kMeshes, (*made)->bytes()), next_order_++,
                    Upload::Clock::now(), std::move(stored)};
  }
  return kept->second.mesh;
}

void BlobStore::set_aside(const std::shared_ptr<Upload>& upload) {
  const std::lock_guard lock(mutex_);
  const auto mine = std::find_if(pending_.begin(), pending_.end(),
                                 [&](const Pending& pending) { return pending.upload == upload; });
  if (mine == pending_.end()) return;  // dropped to make room
  if (const auto other = set_aside_of(upload->digest()); other != pending_.end()) {
    const bool longer = upload->committed() > other->upload->committed();
    erase(longer ? other->upload.get() : upload.get());
    if (!longer) return;
  }
  mine->set_aside = true;
}

void BlobStore::abandon(const std::shared_ptr<Upload>& upload) {
  const std::lock_guard lock(mutex_);
  erase(upload.get());
}

UploadStatus BlobStore::status(const BlobDigest& digest) const {
  const std::lock_guard lock(mutex_);
  if (meshes_.contains(digest)) return {digest.size, true};
  const auto found = set_aside_of(digest);
  return {found == pending_.end() ? 0 : found->upload->committed(), false};
}

std::uint64_t BlobStore::tree_bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const auto& [digest, stored] : meshes_) bytes += stored.mesh->tree_bytes();
  return bytes;
}

BlobStore::PendingList::const_iterator BlobStore::set_aside_of(const BlobDigest& digest) const {
  return std::find_if(pending_.begin(), pending_.end(), [&](const Pending& pending) {
    return pending.set_aside && pending.upload->digest() == digest;
  });
}

void BlobStore::erase(const Upload* upload) {
  const auto found = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& pending) {
    return pending.upload.get() == upload;
  });
  if (found == pending_.end()) return;
  pending_.erase(found);
}

bool BlobStore::drop_set_aside() { return drop_upload(false); }

bool BlobStore::drop_idle() { return drop_upload(true); }

bool BlobStore::drop_upload(bool idle) {
  std::shared_ptr<Upload> upload;  // destroyed after the lock is released
  const auto idle_since = Upload::Clock::now() - limits_.idle;
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& pending) {
    const bool may_go = idle ? pending.upload->last_progress() <= idle_since : pending.set_aside;
    return may_go && pending.upload->drop();
  });
  if (found == pending_.end()) return false;
  upload = found->upload;
  erase(upload.get());
  return true;
}

std::optional<std::uint64_t> BlobStore::drop_unused_mesh(Unused which) {
  Stored dropped;  // destroyed after the lock is released: a mesh and its tree may be large
  const std::lock_guard lock(mutex_);
  const auto stale_since = Upload::Clock::now() - limits_.fresh;
  // Pointers are only copied under the lock, so a use count of 1 cannot grow meanwhile.
  auto oldest = meshes_.end();
  for (auto it = meshes_.begin(); it != meshes_.end(); ++it) {
    if (it->second.mesh.use_count() > 1) continue;
    if (oldest == meshes_.end() || it->second.order < oldest->second.order) oldest = it;
  }
  if (oldest == meshes_.end()) return std::nullopt;
  if (which == Unused::kStale && oldest->second.arrived > stale_since) return std::nullopt;
  dropped = std::move(oldest->second);
  meshes_.erase(oldest);
  return dropped.mesh->tree_bytes();
}

}  // namespace sightline::server::blobs
