// Blobs of an embedded store: files, and the rows that say which of them count.
#include "server/store/stored_blobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace sightline::server::store {
namespace {

/// Blobs that one transaction removes.
constexpr std::size_t kRemovedAtOnce = 256;
/// Blobs that one transaction looks for, while other readers wait.
constexpr std::size_t kFoundAtOnce = 256;

class MappedBlob final : public BlobBytes {
 public:
  explicit MappedBlob(std::unique_ptr<MappedFile> file) : file_(std::move(file)) {}
  std::span<const std::byte> bytes() const override { return file_->bytes(); }

 private:
  std::unique_ptr<MappedFile> file_;
};

}  // namespace

/// Writes a file, and knows its sum.
class StoredBlobs::Writing final : public BlobWriter {
 public:
  Writing(StoredBlobs& blobs, const blobs::BlobDigest& digest, BlobFiles::Fresh fresh)
      : blobs_(blobs), digest_(digest), fresh_(std::move(fresh)) {
    blobs_.budget_.reserve(digest_.size);
  }
  ~Writing() override {
    blobs_.files_.abandon(fresh_);
    blobs_.budget_.release(written_, digest_.size - written_);
  }
  Writing(const Writing&) = delete;
  Writing& operator=(const Writing&) = delete;

  Status append(std::span<const std::byte> bytes) override {
    if (bytes.size() > digest_.size - written_) {
      return Error{Code::kInvalidArgument,
                   fmt::format("{} bytes arrived beyond the end of {}",
                               bytes.size() - (digest_.size - written_), digest_.text()),
                   "BLOB_TOO_LONG"};
    }
    if (Status written = blobs_.files_.write(fresh_, bytes); !written) return written;
    sum_.update(bytes);
    written_ += bytes.size();
    blobs_.budget_.wrote(bytes.size());
    return {};
  }

  Status finish() override {
    if (written_ != digest_.size || sum_.finish() != digest_.sum) {
      return Error{Code::kDataLoss,
                   fmt::format("the bytes that arrived are not those of {}", digest_.text()),
                   "DIGEST_MISMATCH"};
    }
    return blobs_.store(fresh_, digest_);
  }

 private:
  StoredBlobs& blobs_;
  const blobs::BlobDigest digest_;
  BlobFiles::Fresh fresh_;
  blobs::Sha256 sum_;
  std::uint64_t written_ = 0;
};

Status StoredBlobs::count() {
  const auto totals = reader_([](Database& database) { return blob_totals(database); });
  if (!totals) return totals.error();
  totals_ = *totals;
  budget_.add_blob(totals_.bytes);
  return {};
}

Result<std::unique_ptr<BlobWriter>> StoredBlobs::write(const blobs::BlobDigest& digest) {
  if (has(std::span(&digest, 1)).front())
    return Error{Code::kAlreadyExists, digest.text() + " is stored", "BLOB_STORED"};
  if (const Status fits = budget_.admit(digest.size); !fits) return fits.error();
  auto fresh = files_.create();
  if (!fresh) return fresh.error();
  return std::unique_ptr<BlobWriter>(std::make_unique<Writing>(*this, digest, std::move(*fresh)));
}

Status StoredBlobs::store(BlobFiles::Fresh& fresh, const blobs::BlobDigest& digest) {
  const std::shared_lock lock(removing_);
  if (Status published = files_.publish(fresh, digest); !published) return published;
  bool is_new = false;
  const auto now = std::chrono::system_clock::now();
  Status done = writer_.perform(0, [&](Database& database) {
    Status inserted = insert_blob(database, digest, now);
    is_new = database.changes() > 0;
    return inserted;
  });
  if (!done) return done;
  if (is_new) add(digest);
  remember(digest, State::kVerified);
  return {};
}

void StoredBlobs::add(const blobs::BlobDigest& digest) {
  budget_.add_blob(digest.size);
  const std::lock_guard lock(mutex_);
  totals_.count += 1;
  totals_.bytes += digest.size;
}

void StoredBlobs::remember(const blobs::BlobDigest& digest, State state) {
  const std::lock_guard lock(mutex_);
  states_[digest] = state;
}

std::vector<bool> StoredBlobs::has(std::span<const blobs::BlobDigest> digests) {
  const std::shared_lock keep(removing_);
  std::vector<bool> there = find(digests);
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < digests.size(); ++i) {
    if (!there[i]) continue;
    const auto known = states_.find(digests[i]);
    // A damaged blob can be stored again.
    there[i] = known == states_.end() || known->second != State::kCorrupt;
    if (there[i]) asked_[digests[i]] = Clock::now();
  }
  return there;
}

/// Which of them the table has: none where it cannot be read.
std::vector<bool> StoredBlobs::find(std::span<const blobs::BlobDigest> digests) {
  std::vector<bool> there(digests.size());
  for (std::size_t first = 0; first < digests.size(); first += kFoundAtOnce) {
    const std::size_t end = std::min(first + kFoundAtOnce, digests.size());
    const auto found = reader_([&](Database& database) -> Result<std::size_t> {
      for (std::size_t i = first; i < end; ++i) {
        const auto id = find_blob(database, digests[i]);
        if (!id) return id.error();
        there[i] = id->has_value();
      }
      return end;
    });
    if (!found) std::fill_n(there.begin() + static_cast<std::ptrdiff_t>(first), end - first, false);
  }
  return there;
}

Result<std::shared_ptr<const BlobBytes>> StoredBlobs::get(const blobs::BlobDigest& digest) {
  const auto id = reader_([&](Database& database) { return find_blob(database, digest); });
  if (!id) return id.error();
  if (!*id) return Error{Code::kNotFound, digest.text() + " is not stored", "BLOB_NOT_STORED"};
  bool verified = false;
  {
    const std::lock_guard lock(mutex_);
    const auto known = states_.find(digest);
    verified = known != states_.end() && known->second == State::kVerified;
  }
  auto mapped = files_.map(digest);
  if (mapped && !verified) {
    if (!matches((*mapped)->bytes(), digest)) {
      mapped = corrupt_blob(files_.path_of(digest), digest, "has other bytes");
    } else {
      remember(digest, State::kVerified);
    }
  }
  if (!mapped) {
    if (mapped.error().code == Code::kDataLoss) remember(digest, State::kCorrupt);
    return mapped.error();
  }
  return std::shared_ptr<const BlobBytes>(std::make_shared<MappedBlob>(std::move(*mapped)));
}

/// Whether the blob was asked for since then.
bool StoredBlobs::is_recent(const blobs::BlobDigest& digest, Clock::time_point since) const {
  const std::lock_guard lock(mutex_);
  const auto asked = asked_.find(digest);
  return asked != asked_.end() && asked->second > since;
}

Result<std::uint64_t> StoredBlobs::sweep(
    Clock::duration grace, const std::function<bool(const blobs::BlobDigest&)>& in_use) {
  const auto since = Clock::now() - grace;
  // Who asked for a blob before the start is not known.
  if (grace > Clock::duration::zero() && opened_ > since) return std::uint64_t{0};
  const auto stored_before =
      std::chrono::system_clock::now() -
      std::chrono::duration_cast<std::chrono::system_clock::duration>(grace) +
      std::chrono::milliseconds(grace > Clock::duration::zero() ? 0 : 1);
  auto unnamed =
      reader_([&](Database& database) { return unnamed_blobs(database, stored_before); });
  if (!unnamed) return unnamed.error();
  std::erase_if(*unnamed, [&](const BlobRow& row) {
    return is_recent(row.digest, since) || (in_use && in_use(row.digest));
  });
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < unnamed->size(); i += kRemovedAtOnce) {
    const auto removed = remove_some(
        std::span(*unnamed).subspan(i, std::min(kRemovedAtOnce, unnamed->size() - i)), since);
    if (!removed) return removed.error();
    bytes += *removed;
  }
  const std::lock_guard lock(mutex_);
  std::erase_if(asked_, [&](const auto& entry) { return entry.second <= since; });
  return bytes;
}

Status StoredBlobs::remove_rows(std::span<const BlobRow> rows, Clock::time_point since,
                                std::vector<blobs::BlobDigest>& removed) {
  return writer_.perform(0, [&](Database& database) -> Status {
    removed.clear();
    for (const BlobRow& row : rows) {
      if (is_recent(row.digest, since)) continue;
      const auto deleted = delete_unnamed(database, row.id);
      if (!deleted) return deleted.error();
      if (*deleted) removed.push_back(row.digest);
    }
    return {};
  });
}

/// A file that a crash or an error leaves is an orphan, which the doctor removes.
Result<std::uint64_t> StoredBlobs::remove_some(std::span<const BlobRow> rows,
                                               Clock::time_point since) {
  const std::lock_guard lock(removing_);
  std::vector<blobs::BlobDigest> removed;
  if (const Status done = remove_rows(rows, since, removed); !done) return done.error();
  std::uint64_t bytes = 0;
  Status files_removed;
  for (const blobs::BlobDigest& digest : removed) {
    if (const Status done = files_.remove(digest); !done) files_removed = done;
    bytes += digest.size;
    budget_.remove_blob(digest.size);
    const std::lock_guard state_lock(mutex_);
    totals_.count -= 1;
    totals_.bytes -= digest.size;
    states_.erase(digest);
  }
  if (!files_removed) return files_removed.error();
  return bytes;
}

BlobTotals StoredBlobs::totals() const {
  const std::lock_guard lock(mutex_);
  return totals_;
}

}  // namespace sightline::server::store
