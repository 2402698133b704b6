// Copies of blobs on this machine, of those that are stored in PostgreSQL.
#include "server/store/postgres/mesh_cache.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "server/store/errors.h"

namespace sightline::server::store::postgres {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOwnPrefix = "sightline-meshes-";
constexpr const char* kLock = "lock";

/// A directory that this user has made, and no other can write to.
bool is_own(const fs::path& directory) {
  struct stat facts {};
  return lstat(directory.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) &&
         facts.st_uid == geteuid() && (facts.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

struct Locked {
  fs::path directory;
  net::Descriptor lock;
};

Result<Locked> lock_named(FileSystem& files, const fs::path& directory) {
  if (const Status made = files.make_directory(directory); !made) return made.error();
  auto lock = files.lock(directory / kLock);
  if (lock) return Locked{directory, std::move(*lock)};
  if (lock.error().reason != "LOCKED") return lock.error();
  return Error{
      Code::kFailedPrecondition,
      fmt::format("another process uses {}; end it, or name another directory", directory.string()),
      "DATA_DIR_IN_USE"};
}

/// Locks a temporary directory. One that a process which has ended left behind is used again.
Result<Locked> lock_own(FileSystem& files) {
  std::error_code error;
  const fs::path parent = fs::temp_directory_path(error);
  for (fs::directory_iterator entry(parent, error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path& path = entry->path();
    if (!path.filename().string().starts_with(kOwnPrefix) || !is_own(path)) continue;
    if (auto lock = files.lock(path / kLock)) return Locked{path, std::move(*lock)};
  }
  for (;;) {
    std::string fresh = (parent / (std::string(kOwnPrefix) + "XXXXXX")).string();
    if (mkdtemp(fresh.data()) == nullptr) return file_error("make a directory in", parent, errno);
    auto lock = files.lock(fs::path(fresh) / kLock);
    if (lock) return Locked{fresh, std::move(*lock)};
    if (lock.error().reason != "LOCKED" && files.exists(fresh)) return lock.error();
    // Another process took the directory for one that was left behind.
  }
}

/// The lock goes last: a process that finds the directory after that may use it, while it exists.
void remove_own(const fs::path& directory) {
  std::error_code ignored;
  for (fs::directory_iterator entry(directory, ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    if (entry->path().filename() == kLock) continue;
    std::error_code not_removed;
    fs::remove_all(entry->path(), not_removed);
  }
  fs::remove(directory / kLock, ignored);
  fs::remove(directory, ignored);
}

/// The digest that a file is named by; nothing if it has another name.
Result<blobs::BlobDigest> digest_of(const FileEntry& file) {
  return blobs::BlobDigest::parse(
      fmt::format("sha256:{}/{}", file.path.filename().string(), file.size));
}

}  // namespace

MeshCache::MeshCache(FileSystem& files, fs::path directory, net::Descriptor lock, bool is_temporary,
                     const StoreLimits& limits)
    : files_(files),
      directory_(std::move(directory)),
      lock_(std::move(lock)),
      is_temporary_(is_temporary),
      limits_(limits),
      blobs_(files, directory_) {}

MeshCache::~MeshCache() {
  if (is_temporary_) remove_own(directory_);
}

Result<std::unique_ptr<MeshCache>> MeshCache::open(FileSystem& files, const fs::path& directory,
                                                   const StoreLimits& limits) {
  auto locked = directory.empty() ? lock_own(files) : lock_named(files, directory);
  if (!locked) return locked.error();
  std::unique_ptr<MeshCache> cache(new MeshCache(
      files, std::move(locked->directory), std::move(locked->lock), directory.empty(), limits));
  if (const Status ready = cache->blobs_.prepare(); !ready) return ready.error();
  if (const Status counted = cache->count(); !counted) return counted.error();
  return cache;
}

Status MeshCache::count() {
  const auto found = blobs_.list();
  if (!found) return found.error();
  const std::lock_guard lock(mutex_);
  for (const FileEntry& file : *found) {
    const auto digest = digest_of(file);
    if (!digest) continue;
    entries_[*digest] = {};
    bytes_ += file.size;
  }
  drop_oldest();
  return {};
}

std::unique_ptr<MappedFile> MeshCache::find(const blobs::BlobDigest& digest) {
  bool verified = false;
  {
    const std::lock_guard lock(mutex_);
    const auto entry = entries_.find(digest);
    if (entry == entries_.end()) return nullptr;
    entry->second.used = ++uses_;
    verified = entry->second.verified;
  }
  auto mapped = blobs_.map(digest);
  if (!mapped || (!verified && !matches((*mapped)->bytes(), digest))) {
    remove(digest);
    return nullptr;
  }
  const std::lock_guard lock(mutex_);
  if (const auto entry = entries_.find(digest); entry != entries_.end())
    entry->second.verified = true;
  return std::move(*mapped);
}

Result<std::unique_ptr<MeshCache::Copy>> MeshCache::create(std::uint64_t bytes) {
  const auto free = files_.bytes_free(directory_);
  if (!free) return free.error();
  if (*free < bytes || *free - bytes < limits_.min_free_disk) return disk_full(directory_);
  auto fresh = blobs_.create();
  if (!fresh) return fresh.error();
  return std::make_unique<Copy>(*this, std::move(*fresh));
}

Status MeshCache::Copy::append(std::span<const std::byte> bytes) {
  if (Status written = cache_.blobs_.write(fresh_, bytes); !written) return written;
  sum_.update(bytes);
  size_ += bytes.size();
  return {};
}

Result<std::unique_ptr<MappedFile>> MeshCache::Copy::keep(const blobs::BlobDigest& digest) {
  if (size_ != digest.size || sum_.finish() != digest.sum) {
    return Error{Code::kDataLoss,
                 fmt::format("the bytes that arrived are not those of {}", digest.text()),
                 "DIGEST_MISMATCH"};
  }
  // The file is mapped first: it may be dropped as soon as it has a name.
  auto mapped = cache_.files_.map(fresh_.path);
  if (!mapped) return mapped;
  if (const Status named = cache_.blobs_.name(fresh_, digest); !named) return named.error();
  cache_.add(digest);
  return mapped;
}

void MeshCache::add(const blobs::BlobDigest& digest) {
  const std::lock_guard lock(mutex_);
  const auto [entry, is_new] = entries_.try_emplace(digest);
  entry->second = {++uses_, true};
  if (is_new) bytes_ += digest.size;
  drop_oldest();
}

/// Call it with the lock held.
void MeshCache::drop_oldest() {
  while (bytes_ > limits_.cache_bytes && !entries_.empty()) {
    const auto oldest =
        std::ranges::min_element(entries_, {}, [](const auto& entry) { return entry.second.used; });
    (void)blobs_.remove(oldest->first);
    bytes_ -= oldest->first.size;
    entries_.erase(oldest);
  }
}

void MeshCache::remove(const blobs::BlobDigest& digest) {
  const std::lock_guard lock(mutex_);
  if (entries_.erase(digest) == 0) return;
  bytes_ -= digest.size;
  (void)blobs_.remove(digest);
}

std::uint64_t MeshCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::uint64_t MeshCache::bytes_free() const {
  const auto free = files_.bytes_free(directory_);
  return free ? *free : 0;
}

}  // namespace sightline::server::store::postgres
