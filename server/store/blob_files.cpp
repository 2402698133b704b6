// Blobs as files named by their digest.
#include "server/store/blob_files.h"

#include <fmt/format.h>

#include <iterator>
#include <utility>

namespace sightline::server::store {
namespace {

constexpr int kFolders = 256;  // one for each first byte of a sum

}  // namespace

Error corrupt_blob(const std::filesystem::path& file, const blobs::BlobDigest& digest,
                   std::string_view what) {
  return {Code::kDataLoss,
          fmt::format("the bytes of {} are damaged: {} {}; upload it again, or restore {} from a "
                      "backup",
                      digest.text(), file.string(), what, file.filename().string()),
          "BLOB_CORRUPT"};
}

bool matches(std::span<const std::byte> bytes, const blobs::BlobDigest& digest) {
  if (bytes.size() != digest.size) return false;
  blobs::Sha256 sum;
  sum.update(bytes);
  return sum.finish() == digest.sum;
}

Status BlobFiles::prepare() {
  // The last one that is made stands for all.
  const Path last = fresh_directory();
  if (!files_.exists(last)) {
    Status made = files_.make_directory(root_);
    for (int i = 0; made && i < kFolders; ++i)
      made = files_.make_directory(root_ / fmt::format("{:02x}", i));
    if (made) made = files_.make_directory(last);
    if (made) made = files_.sync_directory(root_);
    if (made) made = files_.sync_directory(root_.parent_path());
    if (!made) return made;
  }
  const auto old = files_.list(last);
  if (!old) return old.error();
  for (const FileEntry& file : *old) {
    if (Status removed = files_.remove(file.path); !removed) return removed;
  }
  return {};
}

BlobFiles::Path BlobFiles::path_of(const blobs::BlobDigest& digest) const {
  std::string hex;
  for (const std::uint8_t byte : digest.sum)
    fmt::format_to(std::back_inserter(hex), "{:02x}", byte);
  return root_ / hex.substr(0, 2) / hex;
}

Result<BlobFiles::Fresh> BlobFiles::create() {
  Fresh fresh;
  fresh.path = fresh_directory() / std::to_string(next_++);
  auto file = files_.create(fresh.path);
  if (!file) return file.error();
  fresh.file = std::move(*file);
  return fresh;
}

Status BlobFiles::write(const Fresh& fresh, std::span<const std::byte> bytes) {
  return files_.write(fresh.file, bytes, fresh.path);
}

Status BlobFiles::publish(Fresh& fresh, const blobs::BlobDigest& digest) {
  if (Status synced = files_.sync(fresh.file, fresh.path); !synced) return synced;
  if (Status named = name(fresh, digest); !named) return named;
  return files_.sync_directory(path_of(digest).parent_path());
}

Status BlobFiles::name(Fresh& fresh, const blobs::BlobDigest& digest) {
  if (Status renamed = files_.rename(fresh.path, path_of(digest)); !renamed) return renamed;
  fresh = {};
  return {};
}

void BlobFiles::abandon(Fresh& fresh) {
  if (!fresh.path.empty()) (void)files_.remove(fresh.path);
  fresh = {};
}

Result<std::unique_ptr<MappedFile>> BlobFiles::map(const blobs::BlobDigest& digest) const {
  const Path path = path_of(digest);
  auto mapped = files_.map(path);
  if (!mapped && mapped.error().code == Code::kNotFound)
    return corrupt_blob(path, digest, "is missing");
  if (mapped && (*mapped)->bytes().size() != digest.size) {
    return corrupt_blob(
        path, digest, fmt::format("has {} bytes, not {}", (*mapped)->bytes().size(), digest.size));
  }
  return mapped;
}

Status BlobFiles::remove(const blobs::BlobDigest& digest) { return files_.remove(path_of(digest)); }

Result<std::vector<FileEntry>> BlobFiles::list() const {
  std::vector<FileEntry> all;
  for (int i = 0; i < kFolders; ++i) {
    auto some = files_.list(root_ / fmt::format("{:02x}", i));
    if (!some) return some.error();
    all.insert(all.end(), std::make_move_iterator(some->begin()),
               std::make_move_iterator(some->end()));
  }
  return all;
}

}  // namespace sightline::server::store
