// The account of all bytes that the server holds.
#include "server/exec/memory_account.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace sightline::server::exec {

MemoryAccount::Charge& MemoryAccount::Charge::operator=(Charge&& other) noexcept {
  if (this == &other) return *this;
  release();
  account_ = std::exchange(other.account_, nullptr);
  kind_ = other.kind_;
  bytes_ = std::exchange(other.bytes_, 0);
  return *this;
}

void MemoryAccount::Charge::resize(std::uint64_t bytes) {
  if (account_ == nullptr) return;
  account_->add(kind_, bytes - bytes_);
  bytes_ = bytes;
}

void MemoryAccount::Charge::release() {
  resize(0);
  account_ = nullptr;
}

Result<MemoryAccount::Charge> MemoryAccount::charge(Held kind, std::uint64_t bytes) {
  if (!fits(kind, bytes)) return over(bytes);
  Charge charged = record(kind, bytes);
  if (fits(kind, 0)) return charged;
  charged = {};
  return over(bytes);
}

MemoryAccount::Charge MemoryAccount::record(Held kind, std::uint64_t bytes) {
  add(kind, bytes);
  return {this, kind, bytes};
}

/// `bytes` wraps around where less is held.
void MemoryAccount::add(Held kind, std::uint64_t bytes) {
  held_[index(kind)].fetch_add(bytes);
  trees_->add_others(bytes);
}

void MemoryAccount::set_scene_trees(std::uint64_t bytes) {
  trees_->add_others(bytes - held_[index(Held::kTrees)].exchange(bytes));
}

void MemoryAccount::keep_while(std::vector<std::weak_ptr<const void>> users, Charge charge) {
  const std::lock_guard lock(kept_mutex_);
  kept_.push_back({std::move(users), std::move(charge)});
}

void MemoryAccount::release_gone() {
  const std::lock_guard lock(kept_mutex_);
  std::erase_if(kept_, [](const Kept& kept) {
    return std::ranges::all_of(kept.users, [](const auto& user) { return user.expired(); });
  });
}

Result<MemoryAccount::Charge> MemoryAccount::reclaim_and_charge(Held kind, std::uint64_t bytes,
                                                                std::uint64_t held) {
  if (const Status fits = reclaim(kind, bytes, held); !fits) return fits.error();
  return charge(kind, bytes);
}

Result<MemoryAccount::Charge> MemoryAccount::reclaim_and_charge_in_batch(Held kind,
                                                                         std::uint64_t bytes) {
  if (reclaim(kind, bytes)) return record(kind, bytes);
  const std::uint64_t held = used_of_limit();
  if (held - std::min(held, retired()) + bytes <= limit()) return record(kind, bytes);
  return over(bytes);
}

Status MemoryAccount::reclaim(Held kind, std::uint64_t bytes, std::uint64_t held) {
  const bool large = is_large(held + bytes);
  const std::uint64_t needed = bytes + (large ? parts_.small : 0);
  if (fits(kind, needed)) return {};
  // Nothing is dropped for what can never fit.
  if (reclaim_ && needed <= limit()) reclaim_(needed, large);
  if (fits(kind, needed)) return {};
  return over(needed);
}

std::uint64_t MemoryAccount::used() const {
  return std::accumulate(held_.begin(), held_.end(), trees_->held(),
                         [](std::uint64_t sum, const auto& held) { return sum + held.load(); });
}

std::vector<HeldBytes> MemoryAccount::uses() const {
  return {{"meshes", used(Held::kMeshes)},   {"patches", used(Held::kPatches)},
          {"uploads", used(Held::kUploads)}, {"nodes", used(Held::kNodes)},
          {"logs", used(Held::kLogs)},       {"revisions", used(Held::kRevisions)},
          {"calls", used(Held::kCalls)},     {"segments", used(Held::kSegments)},
          {"trees", used(Held::kTrees)}};
}

std::vector<HeldBytes> MemoryAccount::tree_uses() const {
  using accel::kdtree::TreeBytes;
  return {{"scenes", held_[index(Held::kTrees)].load()},
          {"nodes", trees_->held(TreeBytes::kNodes)},
          {"lists", trees_->held(TreeBytes::kLists)},
          {"wide_nodes", trees_->held(TreeBytes::kSubtrees)},
          {"growing", trees_->held(TreeBytes::kGrowing)},
          {"retired", trees_->held(TreeBytes::kRetired)}};
}

bool MemoryAccount::fits(Held kind, std::uint64_t bytes) const {
  std::uint64_t most = limit();
  if (kind == Held::kCalls) {
    // The part of the calls is theirs whatever others hold: trees grow before they are measured.
    if (used(kind) + bytes <= parts_.calls) return true;
    if (bytes > kLargeCall) most -= parts_.small;
  }
  const std::uint64_t now = used_of_limit();
  return now <= most && bytes <= most - now;
}

Error MemoryAccount::over(std::uint64_t bytes) const {
  return {Code::kResourceExhausted,
          fmt::format(
              "{} of {} bytes are held (the memory budget is {}), and {} more do not fit: {} "
              "for meshes, {} for uploads, {} for patched meshes, {} for nodes, {} for "
              "logs, {} for revisions, {} for trees, {} for calls, {} for segments",
              used_of_limit(), limit(), budget_, bytes, used(Held::kMeshes), used(Held::kUploads),
              used(Held::kPatches), used(Held::kNodes), used(Held::kLogs), used(Held::kRevisions),
              used(Held::kTrees), used(Held::kCalls), used(Held::kSegments)),
          kMemoryBudget};
}

}  // namespace sightline::server::exec
