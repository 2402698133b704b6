// Uploads of many meshes, several at a time.
#include "client/mesh_uploads.h"

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace sightline::client {
namespace {

class Uploads {
 public:
  Uploads(const Client& client, std::span<const MeshUpload> uploads,
          const SceneUploadProgress& progress)
      : client_(client), uploads_(uploads), progress_(progress) {
    for (const MeshUpload& one : uploads) total_ += one.blob->size();
  }

  /// Uploads meshes on one thread, until there are none left, or one has failed.
  void work() {
    while (const MeshUpload* const next = take()) {
      const MeshUpload& one = *next;
      std::uint64_t reported = 0;
      const auto report = [&](std::uint64_t bytes) {
        if (bytes > reported) add(bytes - reported);
        reported = std::max(reported, bytes);
      };
      if (const Status done =
              client_.upload_mesh(*one.blob, one.digest, report, failed_.get_token());
          !done)
        return fail(done.error());
      report(one.blob->size());
      release(one);
    }
  }

  void cancel() { failed_.request_stop(); }
  const std::optional<Error>& error() const { return error_; }

 private:
  /// Waits for room among the bytes on their way. Null: there are no more.
  const MeshUpload* take() {
    std::unique_lock lock(mutex_);
    if (error_ || next_ == uploads_.size()) return nullptr;
    const MeshUpload& one = uploads_[next_++];
    changed_.wait(lock, [&] {
      return sending_ == 0 || sending_ + one.blob->size() <= kUploadBytesAtATime || error_;
    });
    sending_ += one.blob->size();
    return &one;
  }

  void release(const MeshUpload& one) {
    const std::lock_guard lock(mutex_);
    sending_ -= one.blob->size();
    changed_.notify_all();
  }

  void add(std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    done_ += bytes;
    if (progress_) progress_(done_, total_);
  }

  /// The first error is the cause; those of the uploads that it cancels are not.
  void fail(const Error& error) {
    {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = error;
    }
    failed_.request_stop();
    changed_.notify_all();
  }

  const Client& client_;
  const std::span<const MeshUpload> uploads_;
  const SceneUploadProgress& progress_;
  std::uint64_t total_ = 0;
  std::stop_source failed_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t next_ = 0;
  std::uint64_t sending_ = 0;  // bytes
  std::uint64_t done_ = 0;
  std::optional<Error> error_;
};

}  // namespace

Status upload_all(const Client& client, std::span<const MeshUpload> uploads,
                  const std::stop_token& stop, const SceneUploadProgress& progress) {
  Uploads all(client, uploads, progress);
  const std::stop_callback cancelled(stop, [&] { all.cancel(); });
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < std::min(kUploadsAtATime, uploads.size()); ++i)
      threads.emplace_back([&] { all.work(); });
  }
  if (all.error()) return *all.error();
  return {};
}

}  // namespace sightline::client
