// The public face of the carrier.
#include "client/update_stream.h"

#include <utility>

#include "client/calls/update_batch.h"
#include "client/calls/update_stream_worker.h"

namespace sightline::client {

UpdateStream::UpdateStream(std::unique_ptr<Carrier> carrier) : carrier_(std::move(carrier)) {}
UpdateStream::UpdateStream(UpdateStream&&) noexcept = default;
UpdateStream& UpdateStream::operator=(UpdateStream&&) noexcept = default;
UpdateStream::~UpdateStream() = default;

Result<std::uint64_t> UpdateStream::send(std::span<const Update> updates) {
  auto messages = pack_batch(updates);
  if (!messages) return messages.error();
  const auto sequence = carrier_->hand_over(*std::move(messages), true);
  if (!sequence) return sequence.error();
  return **sequence;
}

Result<std::optional<std::uint64_t>> UpdateStream::try_send(std::span<const Update> updates) {
  auto messages = pack_batch(updates);
  if (!messages) return messages.error();
  return carrier_->hand_over(*std::move(messages), false);
}

Status UpdateStream::wait(std::uint64_t sequence) { return carrier_->wait(sequence); }
Status UpdateStream::flush() { return carrier_->flush(); }
Status UpdateStream::close() { return carrier_->close(); }
UpdateStreamState UpdateStream::state() const { return carrier_->state(); }

}  // namespace sightline::client
