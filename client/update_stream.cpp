// Forwards the calls of a stream to its worker.
#include "client/update_stream.h"

#include <utility>

#include "client/calls/apply.h"
#include "client/calls/update_stream_worker.h"

namespace sightline::client {

UpdateStream::UpdateStream(std::unique_ptr<calls::UpdateStreamWorker> worker)
    : worker_(std::move(worker)) {}
UpdateStream::UpdateStream(UpdateStream&&) noexcept = default;
UpdateStream& UpdateStream::operator=(UpdateStream&&) noexcept = default;
UpdateStream::~UpdateStream() = default;

Result<std::uint64_t> UpdateStream::send(std::span<const Update> updates) {
  auto messages = calls::pack_batch(updates);
  if (!messages) return messages.error();
  const auto sequence = worker_->enqueue(*std::move(messages), true);
  if (!sequence) return sequence.error();
  return **sequence;
}

Result<std::optional<std::uint64_t>> UpdateStream::try_send(std::span<const Update> updates) {
  auto messages = calls::pack_batch(updates);
  if (!messages) return messages.error();
  return worker_->enqueue(*std::move(messages), false);
}

Status UpdateStream::wait(std::uint64_t sequence) { return worker_->wait(sequence); }
Status UpdateStream::flush() { return worker_->flush(); }
Status UpdateStream::close() { return worker_->close(); }
UpdateStreamState UpdateStream::state() const { return worker_->state(); }

}  // namespace sightline::client
