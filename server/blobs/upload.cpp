// One upload of a blob in progress.
#include "server/blobs/upload.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline::server::blobs {
namespace {

Error dropped(const BlobDigest& digest) {
  return {Code::kAborted,
          fmt::format("the upload of {} was idle and was dropped to make room; start again at 0",
                      digest.text()),
          "UPLOAD_DROPPED"};
}

}  // namespace

bool Upload::is_slow(Clock::time_point since) const {
  if (last_progress() <= since) return true;
  const Clock::time_point begun = begun_.load();
  if (begun > since) return false;
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(Clock::now() - begun);
  return committed() - begun_at_.load() < static_cast<std::uint64_t>(seconds.count()) * kUploadPace;
}

void Upload::resume() {
  begun_ = Clock::now();
  begun_at_ = committed();
}

Status Upload::append(std::uint64_t offset, std::span<const std::byte> bytes) {
  // It holds no more than it declares: the rest is an error.
  const std::uint64_t after = std::min(committed() + bytes.size(), digest_.size);
  if (Status held = slot_->hold(after); !held) return held;
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
  if (content_->writer != nullptr) {
    if (Status written = content_->writer->append(bytes); !written) return written;
  }
  committed_ = content_->reader.received();
  if (committed_ - progress_ >= kUploadProgress || committed_ == digest_.size) {
    progress_ = committed_;
    last_progress_ = Clock::now();
  }
  return {};
}

Result<std::shared_ptr<const scenegraph::model::Mesh>> Upload::finish(
    const accel::mesh::TreeBuilder& builder) {
  const std::lock_guard lock(mutex_);
  if (!content_) return dropped(digest_);
  // Missing bytes have their own error, so the checksum is compared only if all have arrived.
  if (content_->reader.received() == digest_.size && content_->sum.finish() != digest_.sum) {
    return Error{Code::kDataLoss,
                 fmt::format("the bytes that arrived are not those of {}", digest_.text()),
                 "DIGEST_MISMATCH"};
  }
  auto mesh = content_->reader.finish(builder);
  if (!mesh || content_->writer == nullptr) return mesh;
  if (const Status kept = content_->writer->finish(); !kept) return kept.error();
  return mesh;
}

bool Upload::drop() {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return false;
  content_.reset();
  slot_->release();
  return true;
}

}  // namespace sightline::server::blobs
