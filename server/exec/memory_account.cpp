// The account of all bytes that the server holds.
#include "server/exec/memory_account.h"

#include <fmt/format.h>

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
  auto& held = account_->held_[index(kind_)];
  held.fetch_add(bytes - bytes_);  // may wrap around, as unsigned numbers do
  bytes_ = bytes;
}

void MemoryAccount::Charge::release() {
  resize(0);
  account_ = nullptr;
}

Result<MemoryAccount::Charge> MemoryAccount::charge(Held kind, std::uint64_t bytes) {
  if (!fits(kind, bytes)) return over(kind, bytes);
  Charge charged = record(kind, bytes);
  if (fits(kind, 0)) return charged;
  charged = {};
  return over(kind, bytes);
}

MemoryAccount::Charge MemoryAccount::record(Held kind, std::uint64_t bytes) {
  held_[index(kind)].fetch_add(bytes);
  return {this, kind, bytes};
}

Result<MemoryAccount::Charge> MemoryAccount::reclaim_and_charge(Held kind, std::uint64_t bytes) {
  if (const Status fits = reclaim(kind, bytes); !fits) return fits.error();
  return charge(kind, bytes);
}

Status MemoryAccount::reclaim(Held kind, std::uint64_t bytes) {
  if (fits(kind, bytes)) return {};
  // Nothing is dropped for what can never fit.
  if (reclaim_ && bytes <= limit(kind)) reclaim_(bytes);
  if (fits(kind, bytes)) return {};
  return over(kind, bytes);
}

std::uint64_t MemoryAccount::used() const {
  return std::accumulate(held_.begin(), held_.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& held) { return sum + held.load(); });
}

bool MemoryAccount::fits(Held kind, std::uint64_t bytes) const {
  // The part of the calls is theirs whatever others hold: trees grow before they are measured.
  if (kind == Held::kCalls && used(kind) + bytes <= for_calls_) return true;
  const std::uint64_t now = used(), most = limit(kind);
  return now <= most && bytes <= most - now;
}

Error MemoryAccount::over(Held kind, std::uint64_t bytes) const {
  return {
      Code::kResourceExhausted,
      fmt::format("{} of {} bytes are held (the memory budget is {}), and {} more do not fit: {} "
                  "for meshes, {} for uploads, {} for patched meshes, {} for nodes, {} for "
                  "logs, {} for trees, {} for calls",
                  used(), limit(kind), budget_, bytes, used(Held::kMeshes), used(Held::kUploads),
                  used(Held::kPatches), used(Held::kNodes), used(Held::kLogs), used(Held::kTrees),
                  used(Held::kCalls)),
      kMemoryBudget};
}

}  // namespace sightline::server::exec
