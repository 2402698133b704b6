// Fills messages with updates, up to the size of a message.
#include "client/calls/apply.h"

#include <fmt/format.h>

#include <utility>

#include "client/calls/attempts.h"
#include "client/calls/connection.h"
#include "client/wire/scene_codec.h"

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

  std::vector<v1::StreamUpdatesRequest> messages() { return std::move(messages_); }

 private:
  std::vector<v1::StreamUpdatesRequest> messages_;
  std::size_t updates_ = 0;
  std::size_t filled_ = 0;
  std::size_t total_ = 0;
};

// A request is safe to repeat: each has an id, and the server applies an id once.
constexpr Repeat kRepeat = Repeat::kRefusalsAndBreaks;

Result<Applied> send(const Connection& connection, const v1::ApplyUpdatesRequest& request,
                     const std::stop_token& stop) {
  Attempts attempts(connection.small_timeout(), kRepeat);
  v1::ApplyUpdatesResponse response;
  while (true) {
    grpc::ClientContext context;
    context.set_deadline(*attempts.deadline());
    set_route(context, request.scene());
    const std::stop_callback cancel(stop, [&] { context.TryCancel(); });
    const grpc::Status status = connection.scenes->ApplyUpdates(&context, request, &response);
    if (status.ok()) return decode(response);
    const auto pause = attempts.pause(status);
    if (!pause) return rpc_error(status, stop);
    if (!sleep_unless_stopped(*pause, stop)) return Error{Code::kCancelled, "cancelled", {}};
  }
}

// Fills messages with updates and sends them as they get full.
class Batches {
 public:
  Batches(const Connection& connection, const std::string& scene, const ApplyOptions& options)
      : connection_(connection),
        id_(options.request_id.empty() ? random_request_id() : options.request_id),
        stop_(options.stop) {
    request_.set_scene(scene);
    if (options.expected_revision) request_.set_expected_revision(*options.expected_revision);
  }

  Status add(const Update& update) {
    v1::Update encoded = encode(update, aliases_);
    std::size_t bytes = encoded.ByteSizeLong();
    if (bytes_ > 0 && bytes_ + bytes > wire::kMaxUpdateBytes) {
      if (Status sent = flush(); !sent) return sent;
      encoded = encode(update, aliases_);
      bytes = encoded.ByteSizeLong();
    }
    if (const auto* put = std::get_if<PutNode>(&update)) puts_.push_back(put->node);
    bytes_ += bytes + 8;
    *request_.add_updates() = std::move(encoded);
    return {};
  }

  Status flush() {
    request_.set_request_id(sent_ == 0 ? id_ : fmt::format("{}/{}", id_, sent_));
    ++sent_;
    auto applied = send(connection_, request_, stop_);
    if (!applied) return applied.error();
    if (applied->nodes.size() != puts_.size()) {
      return Error{
          Code::kInternal,
          fmt::format("the server named {} nodes for {} put", applied->nodes.size(), puts_.size()),
          {}};
    }
    for (std::size_t i = 0; i < puts_.size(); ++i) {
      if (puts_[i] < 0) aliases_.add(puts_[i], applied->nodes[i]);
    }
    total_.revision = applied->revision;
    total_.token = std::move(applied->token);
    total_.replayed = applied->replayed;
    total_.nodes.insert(total_.nodes.end(), applied->nodes.begin(), applied->nodes.end());
    if (request_.has_expected_revision()) request_.set_expected_revision(applied->revision);
    request_.clear_updates();
    puts_.clear();
    bytes_ = 0;
    return {};
  }

  Applied result() { return std::move(total_); }

 private:
  const Connection& connection_;
  std::string id_;
  std::stop_token stop_;
  int sent_ = 0;
  v1::ApplyUpdatesRequest request_;
  wire::NodeAliases aliases_;
  std::vector<NodeRef> puts_;  // in the message that is being filled
  std::size_t bytes_ = 0;
  Applied total_;
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
  return packer.messages();
}

void set_sequence(std::uint64_t sequence, std::vector<v1::StreamUpdatesRequest>& messages) {
  for (v1::StreamUpdatesRequest& message : messages) {
    message.mutable_batch()->set_sequence(sequence);
  }
}

Result<v1::ApplyUpdatesRequest> encode_batch(std::span<const Update> updates,
                                             const ApplyOptions& options) {
  if (const Status checked = wire::check(updates); !checked) return checked.error();
  v1::ApplyUpdatesRequest request;
  request.set_request_id(options.request_id.empty() ? random_request_id() : options.request_id);
  if (options.expected_revision) request.set_expected_revision(*options.expected_revision);
  for (const Update& update : updates) *request.add_updates() = wire::encode(update);
  if (const std::size_t bytes = request.ByteSizeLong(); bytes > kMaxMessageBytes) {
    return Error{Code::kResourceExhausted,
                 fmt::format("{} updates are {} bytes, of {} that one message may have",
                             updates.size(), bytes, kMaxMessageBytes),
                 {}};
  }
  return request;
}

Applied decode(const v1::ApplyUpdatesResponse& response) {
  return {response.revision().revision(),
          {response.nodes().begin(), response.nodes().end()},
          response.revision().token(),
          response.replayed()};
}

Result<Applied> apply(const Connection& connection, const std::string& scene,
                      std::span<const Update> updates, const ApplyOptions& options) {
  auto request = encode_batch(updates, options);
  if (!request) return request.error();
  request->set_scene(scene);
  return send(connection, *request, options.stop);
}

Begin<Applied> async_apply(const std::shared_ptr<const Connection>& connection,
                           const std::string& scene, std::span<const Update> updates,
                           const ApplyOptions& options) {
  using Request = v1::ApplyUpdatesRequest;
  using Response = v1::ApplyUpdatesResponse;
  auto request = encode_batch(updates, options);
  if (!request) return refused<Applied>(request.error());
  request->set_scene(scene);
  return unary_call<Applied, Request, Response>(
      connection, connection->small_timeout(), kRepeat, {scene}, options.stop, *std::move(request),
      [](const Connection& by, grpc::ClientContext& context, const Request& asked,
         Response& response, std::function<void(grpc::Status)> ended) {
        by.scenes->async()->ApplyUpdates(&context, &asked, &response, std::move(ended));
      },
      [](const Response& response) { return Result<Applied>(decode(response)); });
}

Result<Applied> apply_in_batches(const Connection& connection, const std::string& scene,
                                 std::span<const Update> updates, const ApplyOptions& options) {
  if (const Status checked = wire::check(updates); !checked) return checked.error();
  Batches batches(connection, scene, options);
  for (const Update& update : updates) {
    const Status added =
        wire::each_piece(update, [&](const Update& piece) { return batches.add(piece); });
    if (!added) return added.error();
  }
  if (const Status sent = batches.flush(); !sent) return sent.error();
  return batches.result();
}

}  // namespace sightline::client::calls
