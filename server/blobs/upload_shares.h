// What uploads in progress hold: slots, and the bytes that have arrived. Each caller has a share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "proto/result.h"
#include "server/exec/caller.h"
#include "server/exec/memory_account.h"
#include "server/exec/shares.h"

namespace sightline::server::blobs {

/// Threads: any, for every member.
class UploadShares {
 public:
  /// Ends an upload of this caller, or of the principal or server that it belongs to, if there is
  /// one that may go. Returns whether there was one. Called without locks.
  using EndOne = std::function<bool(const exec::Caller& caller, exec::Exceeded::Scope scope)>;

  /// At most `uploads` at a time. Bytes are charged to `memory`, which outlives this object.
  UploadShares(exec::MemoryAccount& memory, std::size_t uploads, EndOne end_one);

  /// The slot of one upload and its bytes; the destructor gives them back. Must not outlive the
  /// shares. Threads: any, for every member.
  class Slot {
   public:
    Slot(UploadShares& shares, exec::Caller caller)
        : shares_(shares),
          caller_(std::move(caller)),
          charge_(shares.memory_.record(exec::Held::kUploads, 0)) {}
    ~Slot() { release(); }
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;

    const exec::Caller& caller() const { return caller_; }
    /// Call it before the upload has this many bytes in all, and after it has fewer. May take long.
    /// Errors, after which nothing has changed: kResourceExhausted, naming the limit of the server
    /// or of the caller's share.
    Status hold(std::uint64_t bytes);
    /// Gives back the slot and the bytes, once. What is held later is freed at once and not
    /// counted.
    void release();

   private:
    UploadShares& shares_;
    const exec::Caller caller_;
    std::mutex mutex_;                    // protects the next two
    exec::MemoryAccount::Charge charge_;  // the shares hold as many bytes
    bool released_ = false;
  };

  /// Errors: kResourceExhausted, naming the limit.
  Result<std::unique_ptr<Slot>> take(const exec::Caller& caller);

 private:
  Status add_bytes(const exec::Caller& caller, std::uint64_t bytes);
  void remove_bytes(const exec::Caller& caller, std::uint64_t bytes);
  /// Gives back the slot of an upload that held these bytes.
  void remove(const exec::Caller& caller, std::uint64_t bytes);

  exec::MemoryAccount& memory_;
  const EndOne end_one_;
  std::mutex mutex_;  // protects the next two
  exec::Shares slots_, bytes_;
};

}  // namespace sightline::server::blobs
