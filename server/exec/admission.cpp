// A limit on the rays and bytes in flight.
#include "server/exec/admission.h"

#include <fmt/format.h>

#include <string_view>

namespace sightline::server::exec {
namespace {

Error over(std::string_view holder, std::string_view what, std::uint64_t asked,
           std::uint64_t in_flight, std::uint64_t limit) {
  return {
      Code::kResourceExhausted,
      fmt::format("{} has {} {} in flight and {} more would exceed its limit of {}; retry later",
                  holder, in_flight, what, asked, limit),
      kQueueFull};
}

/// Whether `asked` more do not exceed the limit. What is asked for may be any number.
bool fits(std::uint64_t asked, std::uint64_t held, std::uint64_t limit) {
  return held <= limit ? asked <= limit - held : asked == 0;
}

}  // namespace

Result<Admission::Ticket> Admission::admit(const Caller& caller, std::uint64_t rays,
                                           std::uint64_t bytes) {
  MemoryAccount::Charge charge;
  if (memory_ != nullptr) {
    auto charged = capacity_ == Capacity::kReserved ? memory_->record(Held::kCalls, bytes)
                                                    : memory_->charge(Held::kCalls, bytes);
    if (!charged) return charged.error();
    charge = std::move(*charged);
  }
  const std::lock_guard lock(mutex_);
  if (!fits(rays, rays_, limits_.rays) && !may_use_reserve(rays, caller.connection))
    return over("the server", "rays", rays, rays_, limits_.rays);
  if (const auto exceeded = bytes_.exceeded(caller, bytes))
    return over(exceeded->holder(), "bytes", bytes, exceeded->held, exceeded->limit);
  bytes_.add(caller, bytes);
  if (rays > 0) connection_rays_[caller.connection] += rays;
  rays_ += rays;
  return Ticket(this, caller, rays, bytes, std::move(charge));
}

bool Admission::may_use_reserve(std::uint64_t rays, const std::string& connection) const {
  const auto found = connection_rays_.find(connection);
  const std::uint64_t held = found == connection_rays_.end() ? 0 : found->second;
  const std::uint64_t sharing = connection_rays_.size() + (held == 0 ? 1 : 0);
  return sharing > 1 && fits(rays, held, limits_.rays / sharing) &&
         fits(rays, rays_, limits_.rays + limits_.rays / kReserveShare);
}

AdmissionLimits Admission::in_flight() const {
  const std::lock_guard lock(mutex_);
  return {rays_, bytes_.total()};
}

Admission::Ticket& Admission::Ticket::operator=(Ticket&& other) noexcept {
  if (this == &other) return *this;
  release();
  admission_ = std::exchange(other.admission_, nullptr);
  caller_ = std::move(other.caller_);
  charge_ = std::move(other.charge_);
  rays_ = other.rays_;
  bytes_ = other.bytes_;
  return *this;
}

void Admission::Ticket::release() {
  if (admission_ == nullptr) return;
  {
    const std::lock_guard lock(admission_->mutex_);
    admission_->bytes_.remove(caller_, bytes_);
    admission_->rays_ -= rays_;
    const auto connection = admission_->connection_rays_.find(caller_.connection);
    if (connection != admission_->connection_rays_.end()) {
      connection->second -= rays_;
      if (connection->second == 0) admission_->connection_rays_.erase(connection);
    }
  }
  admission_ = nullptr;
  charge_ = {};
}

}  // namespace sightline::server::exec
