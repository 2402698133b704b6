// A limit on the rays and bytes in flight.
#include "server/exec/admission.h"

#include <fmt/format.h>

#include <string_view>

namespace sightline::server::exec {
namespace {

Error over(std::string_view what, std::uint64_t asked, std::uint64_t in_flight,
           std::uint64_t limit) {
  return {
      Code::kResourceExhausted,
      fmt::format(
          "the server has {} {} in flight and {} more would exceed its limit of {}; retry later",
          in_flight, what, asked, limit),
      kQueueFull};
}

}  // namespace

Result<Admission::Ticket> Admission::admit(std::uint64_t rays, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  // The amount in flight never exceeds its limit, so these differences do not wrap around.
  if (rays > limits_.rays - in_flight_.rays) {
    return over("rays", rays, in_flight_.rays, limits_.rays);
  }
  if (bytes > limits_.bytes - in_flight_.bytes) {
    return over("bytes", bytes, in_flight_.bytes, limits_.bytes);
  }
  in_flight_.rays += rays;
  in_flight_.bytes += bytes;
  return Ticket(this, rays, bytes);
}

AdmissionLimits Admission::in_flight() const {
  const std::lock_guard lock(mutex_);
  return in_flight_;
}

Admission::Ticket& Admission::Ticket::operator=(Ticket&& other) noexcept {
  if (this == &other) return *this;
  release();
  admission_ = std::exchange(other.admission_, nullptr);
  rays_ = other.rays_;
  bytes_ = other.bytes_;
  return *this;
}

void Admission::Ticket::release() {
  if (admission_ == nullptr) return;
  const std::lock_guard lock(admission_->mutex_);
  admission_->in_flight_.rays -= rays_;
  admission_->in_flight_.bytes -= bytes_;
  admission_ = nullptr;
}

}  // namespace sightline::server::exec
