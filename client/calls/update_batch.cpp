// Messages are filled one after the other.
#include "client/calls/update_batch.h"

#include <fmt/format.h>

#include <utility>

#include "client/wire/update_codec.h"

namespace sightline::client::calls {
namespace {

Error too_large(std::string message) {
  return {Code::kResourceExhausted, std::move(message), "BATCH_TOO_LARGE"};
}

class Packer {
 public:
  Packer() : messages_(1) { messages_[0].mutable_batch(); }

  Status add(const Update& piece) {
    v1::Update encoded = wire::encode(piece);
    const std::size_t bytes = encoded.ByteSizeLong() + 8;  // with its tag and length
    if (bytes > wire::kMaxUpdateBytes) {
      return too_large(fmt::format("an update is {} bytes, of {} that one message may have", bytes,
                                   wire::kMaxUpdateBytes));
    }
    if (++updates_ > kMaxUpdatesPerBatch)
      return too_large(fmt::format("a batch may have {} updates", kMaxUpdatesPerBatch));
    total_ += bytes;
    if (total_ > kMaxBatchBytes)
      return too_large(fmt::format("a batch may have {} bytes", kMaxBatchBytes));
    if (filled_ + bytes > wire::kMaxUpdateBytes) {
      messages_.back().mutable_batch()->set_more(true);
      messages_.emplace_back().mutable_batch();
      filled_ = 0;
    }
    filled_ += bytes;
    *messages_.back().mutable_batch()->add_updates() = std::move(encoded);
    return {};
  }

  std::vector<v1::StreamUpdatesRequest> take() { return std::move(messages_); }

 private:
  std::vector<v1::StreamUpdatesRequest> messages_;
  std::size_t updates_ = 0;
  std::size_t filled_ = 0;
  std::size_t total_ = 0;
};

}  // namespace

Result<std::vector<v1::StreamUpdatesRequest>> pack_batch(std::span<const Update> updates) {
  if (const Status checked = wire::check(updates); !checked) return checked.error();
  Packer packer;
  for (const Update& update : updates) {
    const Status added =
        wire::each_piece(update, [&](const Update& piece) { return packer.add(piece); });
    if (!added) return added.error();
  }
  return packer.take();
}

void set_sequence(std::uint64_t sequence, std::vector<v1::StreamUpdatesRequest>& messages) {
  for (v1::StreamUpdatesRequest& message : messages) {
    message.mutable_batch()->set_sequence(sequence);
  }
}

}  // namespace sightline::client::calls
