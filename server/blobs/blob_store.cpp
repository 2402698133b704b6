// Meshes by the digest of their bytes, and the uploads in progress.
#include "server/blobs/blob_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace sightline::server::blobs {
namespace {

Error not_stored(const BlobDigest& digest) {
  return {Code::kNotFound, fmt::format("there is no mesh {}", digest.text()), "BLOB_NOT_STORED"};
}

}  // namespace

BlobStore::BlobStore(exec::MemoryAccount& memory, BlobLimits limits, store::Store* disk)
    : memory_(memory),
      limits_(limits),
      disk_(disk),
      upload_shares_(memory, limits.uploads, [this](const exec::Caller& caller, auto scope) {
        const auto is_within = [&](const exec::Caller& owner) {
          return exec::is_within(caller, owner, scope);
        };
        return drop_upload(false, is_within) || drop_upload(true, is_within);
      }) {}

/// Reads the mesh from disk.
class BlobStore::Source final : public scenegraph::model::MeshSource {
 public:
  Source(const BlobStore& blobs, const BlobDigest& digest) : blobs_(blobs), digest_(digest) {}

  Result<std::shared_ptr<const void>> charge(std::uint64_t bytes,
                                             scenegraph::model::Reclaim reclaim) const override {
    auto charge = reclaim == scenegraph::model::Reclaim::kAllowed
                      ? blobs_.memory_.reclaim_and_charge_in_batch(exec::Held::kMeshes, bytes)
                      : blobs_.memory_.charge(exec::Held::kMeshes, bytes);
    if (!charge) return charge.error();
    return std::shared_ptr<const void>(
        std::make_shared<const exec::MemoryAccount::Charge>(std::move(*charge)));
  }

  Result<MeshPointer> read() const override {
    auto mesh = blobs_.read(digest_);
    if (mesh || mesh.error().code != Code::kNotFound) return mesh;
    // The mesh is one of an old revision, and another server has swept it.
    return Error{Code::kOutOfRange, mesh.error().message, mesh.error().reason};
  }

 private:
  const BlobStore& blobs_;
  const BlobDigest digest_;
};

Result<BlobStore::MeshPointer> BlobStore::read(const BlobDigest& digest) const {
  const auto blob = disk_->blob(digest);
  if (!blob) return blob.error();
  MeshBlobReader reader(digest.size);
  if (const Status read = reader.append((*blob)->bytes()); !read)
    return Error{Code::kDataLoss, read.error().message, "BLOB_CORRUPT"};
  auto mesh = reader.finish(builder());
  if (!mesh) return Error{Code::kDataLoss, mesh.error().message, "BLOB_CORRUPT"};
  return mesh;
}

BlobStore::MeshPointer BlobStore::find(const BlobDigest& digest) const {
  const std::lock_guard lock(mutex_);
  const auto found = meshes_.find(digest);
  return found == meshes_.end() ? nullptr : found->second.mesh;
}

bool BlobStore::has(const BlobDigest& digest) const {
  if (disk_ != nullptr) return disk_->has_blob(digest);
  const std::lock_guard lock(mutex_);
  const auto found = meshes_.find(digest);
  if (found == meshes_.end()) return false;
  found->second.used = Upload::Clock::now();
  found->second.released = false;
  return true;
}

std::vector<bool> BlobStore::has(std::span<const BlobDigest> digests) const {
  if (disk_ != nullptr) return disk_->has_blobs(digests);
  std::vector<bool> there;
  there.reserve(digests.size());
  for (const BlobDigest& digest : digests) there.push_back(has(digest));
  return there;
}

Result<BlobStore::MeshPointer> BlobStore::load(const BlobDigest& digest) {
  if (auto mesh = find(digest)) return mesh;
  if (disk_ == nullptr) return not_stored(digest);
  const auto while_read = memory_.reclaim_and_charge(exec::Held::kMeshes, digest.size);
  if (!while_read) return while_read.error();
  auto mesh = read(digest);
  if (!mesh) return mesh.error();
  return insert(digest, std::move(*mesh), {});
}

Result<BlobStore::MeshPointer> BlobStore::use(const BlobDigest& digest) {
  auto mesh = load(digest);
  if (!mesh) return mesh;
  const std::lock_guard lock(mutex_);
  const auto found = meshes_.find(digest);
  if (found != meshes_.end()) found->second.released = true;
  return mesh;
}

Result<BlobStore::MeshPointer> BlobStore::load_patched(const scenegraph::model::Mesh& base,
                                                       const BlobDigest& digest) {
  if (disk_ == nullptr) return not_stored(digest);
  auto charge = memory_.reclaim_and_charge(exec::Held::kPatches, base.bytes_deformed());
  if (!charge) return charge.error();
  if (const Status resident = base.make_resident(scenegraph::model::Reclaim::kAllowed); !resident)
    return resident.error();
  const auto mesh = read(digest);
  if (!mesh) return mesh.error();
  const auto vertices = (*mesh)->view().vertices;
  return base.deformed({vertices.begin(), vertices.end()},
                       std::make_shared<exec::MemoryAccount::Charge>(std::move(*charge)));
}

Result<BlobDigest> BlobStore::keep(const scenegraph::model::Mesh& mesh) {
  const BlobDigest digest = digest_of(mesh);
  if (disk_ == nullptr || disk_->has_blob(digest)) return digest;
  auto writing = disk_->write_blob(digest);
  if (!writing && writing.error().code == Code::kAlreadyExists) return digest;
  if (!writing) return writing.error();
  const Status written = write_mesh_blob(
      mesh, [&](std::span<const std::byte> bytes) { return (*writing)->append(bytes); });
  if (!written) return written.error();
  if (const Status kept = (*writing)->finish(); !kept) return kept.error();
  return digest;
}

BlobStore::MeshPointer BlobStore::insert(const BlobDigest& digest, MeshPointer mesh,
                                         exec::MemoryAccount::Charge charge) {
  const std::lock_guard lock(mutex_);
  const auto [kept, is_new] = meshes_.try_emplace(digest);
  if (is_new) {
    if (disk_ != nullptr) mesh = mesh->unread(std::make_unique<Source>(*this, digest));
    kept->second = {std::move(mesh), std::move(charge), next_order_++, Upload::Clock::now()};
  }
  kept->second.used = Upload::Clock::now();
  kept->second.released = false;
  return kept->second.mesh;
}

/// A writer of the blob; null without a disk, or if the blob is there.
Result<std::unique_ptr<store::BlobWriter>> BlobStore::writer(const BlobDigest& digest) {
  if (disk_ == nullptr) return std::unique_ptr<store::BlobWriter>();
  auto writing = disk_->write_blob(digest);
  if (!writing && writing.error().code == Code::kAlreadyExists)
    return std::unique_ptr<store::BlobWriter>();
  return writing;
}

Result<std::shared_ptr<Upload>> BlobStore::begin(const BlobDigest& digest, std::uint64_t offset,
                                                 const exec::Caller& caller,
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
  if (digest.size > memory_.limit()) {
    return Error{Code::kResourceExhausted,
                 fmt::format("a blob of {} bytes does not fit into the {} bytes for uploads of the "
                             "memory budget of {}",
                             digest.size, memory_.limit(), memory_.budget()),
                 exec::kMemoryBudget};
  }
  auto slot = upload_shares_.take(caller);
  if (!slot) return slot.error();
  auto writing = writer(digest);
  if (!writing) return writing.error();
  auto upload = std::make_shared<Upload>(digest, std::move(*slot), std::move(*writing));
  const std::lock_guard lock(mutex_);
  pending_.push_back({upload, std::move(stored), false});
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
  pending_.splice(pending_.end(), pending_, found);
  pending_.back().set_aside = false;
  pending_.back().upload->resume();
  return pending_.back().upload;
}

Result<BlobStore::MeshPointer> BlobStore::complete(const std::shared_ptr<Upload>& upload) {
  Result<MeshPointer> made = upload->finish(builder());
  exec::Quotas::Use stored;
  {
    const std::lock_guard lock(mutex_);
    const auto pending = std::find_if(pending_.begin(), pending_.end(),
                                      [&](const Pending& one) { return one.upload == upload; });
    if (pending != pending_.end()) stored = std::move(pending->stored);
    erase(upload.get());
  }
  if (!made) return made;
  exec::MemoryAccount::Charge charge;
  if (disk_ == nullptr) charge = memory_.record(exec::Held::kMeshes, (*made)->bytes());
  {
    const std::lock_guard lock(mutex_);
    quotas_.try_emplace(upload->digest(), std::move(stored));
  }
  return insert(upload->digest(), std::move(*made), std::move(charge));
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
  if (has(digest)) return {digest.size, true};
  const std::lock_guard lock(mutex_);
  const auto found = set_aside_of(digest);
  return {found == pending_.end() ? 0 : found->upload->committed(), false};
}

std::vector<BlobStore::MeshPointer> BlobStore::meshes() const {
  const std::lock_guard lock(mutex_);
  std::vector<MeshPointer> meshes;
  meshes.reserve(meshes_.size());
  for (const auto& [digest, stored] : meshes_) meshes.push_back(stored.mesh);
  return meshes;
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
  found->upload->leave();
  pending_.erase(found);
}

bool BlobStore::drop_set_aside() {
  return drop_upload(false, [](const exec::Caller&) { return true; });
}

bool BlobStore::drop_idle() {
  return drop_upload(true, [](const exec::Caller&) { return true; });
}

bool BlobStore::drop_upload(bool idle, const MayGo& may_go) {
  std::shared_ptr<Upload> upload;  // destroyed after the lock is released
  const auto idle_since = Upload::Clock::now() - limits_.idle;
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& pending) {
    const bool rests = idle ? pending.upload->is_slow(idle_since) : pending.set_aside;
    return rests && may_go(pending.upload->caller()) && pending.upload->drop();
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
  if (disk_ == nullptr) quotas_.erase(oldest->first);
  meshes_.erase(oldest);
  return dropped.mesh->tree_bytes();
}

void BlobStore::drop_unused_meshes() {
  std::vector<Stored> dropped;  // destroyed after the lock is released
  const auto now = Upload::Clock::now();
  const auto unused = disk_ == nullptr ? limits_.unused : limits_.unused_on_disk;
  const auto released = std::min(unused, limits_.released);
  const std::lock_guard lock(mutex_);
  for (auto it = meshes_.begin(); it != meshes_.end();) {
    const auto mesh = it++;
    Stored& stored = mesh->second;
    const bool in_use = stored.mesh.use_count() > 1;
    if (in_use) stored.used = now;
    if (in_use || stored.used > now - (stored.released ? released : unused)) continue;
    dropped.push_back(std::move(stored));
    if (disk_ == nullptr) quotas_.erase(mesh->first);
    meshes_.erase(mesh);
  }
}

Result<std::uint64_t> BlobStore::sweep(Upload::Clock::duration grace) {
  std::vector<Stored> dropped;  // destroyed after the lock is released
  return disk_->sweep(grace, [&](const BlobDigest& digest) {
    const std::lock_guard lock(mutex_);
    const auto found = meshes_.find(digest);
    if (found != meshes_.end()) {
      if (found->second.mesh.use_count() > 1) return true;
      dropped.push_back(std::move(found->second));
      meshes_.erase(found);
    }
    quotas_.erase(digest);
    return false;
  });
}

}  // namespace sightline::server::blobs
