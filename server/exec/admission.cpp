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

/// Whether `asked` more do not exceed the limit. What is asked for may be any number.
bool fits(const AdmissionLimits& asked, const AdmissionLimits& held, const AdmissionLimits& limit) {
  const auto fit = [](std::uint64_t more, std::uint64_t now, std::uint64_t most) {
    return now <= most ? more <= most - now : more == 0;
  };
  return fit(asked.rays, held.rays, limit.rays) && fit(asked.bytes, held.bytes, limit.bytes);
}

void add(AdmissionLimits& sum, const AdmissionLimits& more) {
  sum.rays += more.rays;
  sum.bytes += more.bytes;
}

void subtract(AdmissionLimits& sum, const AdmissionLimits& less) {
  sum.rays -= less.rays;
  sum.bytes -= less.bytes;
}

}  // namespace

Result<Admission::Ticket> Admission::admit(const Caller& caller, std::uint64_t rays,
                                           std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  const AdmissionLimits asked{rays, bytes};
  if (!fits(asked, in_flight_, limits_) && !may_use_reserve(asked, caller.connection)) {
    return fits({rays, 0}, in_flight_, limits_)
               ? over("bytes", bytes, in_flight_.bytes, limits_.bytes)
               : over("rays", rays, in_flight_.rays, limits_.rays);
  }
  if (!caller.connection.empty()) {
    Connection& connection = connections_[caller.connection];
    add(connection.in_flight, asked);
    ++connection.tickets;
  }
  Ticket ticket;
  ticket.connection_ = caller.connection;
  ticket.held_ = asked;
  ticket.admission_ = this;
  add(in_flight_, asked);
  return ticket;
}

bool Admission::may_use_reserve(const AdmissionLimits& asked, const std::string& connection) const {
  const auto found = connections_.find(connection);
  const bool is_new = found == connections_.end();
  const std::uint64_t sharing = connections_.size() + (is_new ? 1 : 0);
  if (connection.empty() || sharing < 2) return false;
  const AdmissionLimits share{limits_.rays / sharing, limits_.bytes / sharing};
  const AdmissionLimits extended{limits_.rays + limits_.rays / kReserveShare,
                                 limits_.bytes + limits_.bytes / kReserveShare};
  return fits(asked, is_new ? AdmissionLimits{0, 0} : found->second.in_flight, share) &&
         fits(asked, in_flight_, extended);
}

AdmissionLimits Admission::in_flight() const {
  const std::lock_guard lock(mutex_);
  return in_flight_;
}

Admission::Ticket& Admission::Ticket::operator=(Ticket&& other) noexcept {
  if (this == &other) return *this;
  release();
  admission_ = std::exchange(other.admission_, nullptr);
  held_ = other.held_;
  connection_ = std::move(other.connection_);
  return *this;
}

void Admission::Ticket::release() {
  if (admission_ == nullptr) return;
  const std::lock_guard lock(admission_->mutex_);
  subtract(admission_->in_flight_, held_);
  const auto connection = admission_->connections_.find(connection_);
  if (connection != admission_->connections_.end()) {
    subtract(connection->second.in_flight, held_);
    if (--connection->second.tickets == 0) admission_->connections_.erase(connection);
  }
  admission_ = nullptr;
}

}  // namespace sightline::server::exec
