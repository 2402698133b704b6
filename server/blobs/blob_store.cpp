// Meshes by the digest of their bytes, and uploads in progress, within one memory budget.
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
  last_active_ = Clock::now();
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

Result<std::shared_ptr<Upload>> BlobStore::begin(const BlobDigest& digest, std::uint64_t offset) {
  if (digest.size < kMeshBlobHeader) {
    return Error{Code::kInvalidArgument,
                 fmt::format("a blob of {} bytes is shorter than the {} bytes of a mesh's header",
                             digest.size, kMeshBlobHeader),
                 "BAD_MESH_BLOB"};
  }
  Freed freed;  // destroyed after the lock is released: a mesh and its tree may be large
  const std::lock_guard lock(mutex_);
  if (offset != 0) return resume(digest, offset);
  if (const auto old = set_aside_of(digest); old != pending_.end()) {
    freed.push_back(old->upload);
    erase(old->upload.get());
  }
  if (const Status evicted = evict_for(digest.size, freed); !evicted) return evicted.error();
  auto upload = std::make_shared<Upload>(digest);
  pending_.push_back({upload, false});
  bytes_used_ += digest.size;
  return upload;
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
  auto upload = found->upload;
  pending_.erase(found);
  pending_.push_back({upload, false});
  return upload;
}

Result<BlobStore::MeshPointer> BlobStore::complete(const std::shared_ptr<Upload>& upload) {
  Result<MeshPointer> made = upload->finish();
  const std::lock_guard lock(mutex_);
  erase(upload.get());
  if (!made) return made;
  const Stored stored{*made, (*made)->bytes(), next_order_++};
  const auto [kept, is_new] = meshes_.try_emplace(upload->digest(), stored);
  if (is_new) bytes_used_ += kept->second.bytes;
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

std::uint64_t BlobStore::bytes_used() const {
  const std::lock_guard lock(mutex_);
  return bytes_used_;
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
  bytes_used_ -= upload->digest().size;
  pending_.erase(found);
}

Status BlobStore::evict_for(std::uint64_t bytes, Freed& freed) {
  if (bytes > limits_.memory_budget) {
    return Error{Code::kResourceExhausted,
                 fmt::format("a blob of {} bytes exceeds the memory budget of {}", bytes,
                             limits_.memory_budget),
                 "MEMORY_BUDGET"};
  }
  while (pending_.size() >= limits_.uploads) {
    if (drop_upload(false, freed) || drop_upload(true, freed)) continue;
    return Error{Code::kResourceExhausted,
                 fmt::format("{} uploads are under way, the limit is {}; retry later",
                             pending_.size(), limits_.uploads),
                 "TOO_MANY_UPLOADS"};
  }
  // Two comparisons, because a mesh may be larger than its blob and the use may exceed the budget.
  while (bytes_used_ > limits_.memory_budget || bytes > limits_.memory_budget - bytes_used_) {
    if (drop_upload(false, freed) || drop_unused_mesh(freed) || drop_upload(true, freed)) continue;
    return Error{
        Code::kResourceExhausted,
        fmt::format("the memory budget holds {} of {} bytes, and a blob of {} more does not fit",
                    bytes_used_, limits_.memory_budget, bytes),
        "MEMORY_BUDGET"};
  }
  return {};
}

bool BlobStore::drop_upload(bool idle, Freed& freed) {
  const auto idle_since = Upload::Clock::now() - limits_.idle;
  const auto found = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& pending) {
    const bool may_go = idle ? pending.upload->last_active() <= idle_since : pending.set_aside;
    return may_go && pending.upload->drop();
  });
  if (found == pending_.end()) return false;
  const auto upload = found->upload;
  freed.push_back(upload);
  erase(upload.get());
  return true;
}

bool BlobStore::drop_unused_mesh(Freed& freed) {
  // Pointers are only copied under the lock, so a use count of 1 cannot grow meanwhile.
  auto oldest = meshes_.end();
  for (auto it = meshes_.begin(); it != meshes_.end(); ++it) {
    if (it->second.mesh.use_count() > 1) continue;
    if (oldest == meshes_.end() || it->second.order < oldest->second.order) oldest = it;
  }
  if (oldest == meshes_.end()) return false;
  bytes_used_ -= oldest->second.bytes;
  freed.push_back(std::move(oldest->second.mesh));
  meshes_.erase(oldest);
  return true;
}

}  // namespace sightline::server::blobs
