// Updates to messages: one for a batch, or as many as it takes, with aliases carried from one to
// the next.
#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "client/channel.h"
#include "client/connection.h"
#include "client/rpc_error.h"
#include "client/scene_codec.h"

namespace sightline::client {
namespace {

constexpr std::size_t kRoomForEnvelope = 4096;  // of a message: scene name, tags and lengths
constexpr std::size_t kMaxUpdateBytes = kMaxMessageBytes - kRoomForEnvelope;
constexpr std::size_t kTransformsPerUpdate = 4096;  // 96 bytes each, and a reference

// Ids of the nodes that earlier messages have made, by alias.
class Aliases {
 public:
  NodeRef resolve(NodeRef ref) const {
    const auto found = ids_.find(ref);
    return found == ids_.end() ? ref : static_cast<NodeRef>(found->second);
  }
  void add(NodeRef alias, std::uint64_t id) { ids_.emplace(alias, id); }

 private:
  std::unordered_map<NodeRef, std::uint64_t> ids_;
};

struct Encoder {
  const Aliases& aliases;
  v1::Update& out;

  void operator()(const PutNode& put) const {
    v1::PutNode& node = *out.mutable_put_node();
    node.set_node(aliases.resolve(put.node));
    node.set_parent(aliases.resolve(put.parent));
    node.set_name(put.name);
    if (put.parent_from_local != kIdentity)
      *node.mutable_transform() = encode(put.parent_from_local);
    node.set_mesh_digest(put.mesh_digest);
    node.set_mobility(encode(put.mobility));
    node.set_mask(put.mask);
  }
  void operator()(const SetTransforms& set) const {
    v1::SetTransforms& transforms = *out.mutable_set_transforms();
    for (const NodeRef node : set.nodes) transforms.add_nodes(aliases.resolve(node));
    static_assert(sizeof(Transform) == 96);
    transforms.set_matrices(set.parent_from_local.data(),
                            set.parent_from_local.size() * sizeof(Transform));
  }
  void operator()(const DeleteNode& deleted) const {
    out.mutable_delete_node()->set_node(aliases.resolve(deleted.node));
    out.mutable_delete_node()->set_subtree(deleted.subtree);
  }
};

v1::Update encode(const Update& update, const Aliases& aliases) {
  v1::Update out;
  std::visit(Encoder{aliases, out}, update);
  return out;
}

Result<Applied> send(const Connection& connection, const v1::ApplyUpdatesRequest& request) {
  grpc::ClientContext context;
  set_timeout(context, connection.small_timeout());
  v1::ApplyUpdatesResponse response;
  const grpc::Status status = connection.scenes->ApplyUpdates(&context, request, &response);
  if (!status.ok()) return rpc_error(status);
  return Applied{response.revision().revision(),
                 {response.nodes().begin(), response.nodes().end()}};
}

// Fills messages with updates and sends them as they get full.
class Batches {
 public:
  Batches(const Connection& connection, const std::string& scene, const ApplyOptions& options)
      : connection_(connection) {
    request_.set_scene(scene);
    if (options.expected_revision) request_.set_expected_revision(*options.expected_revision);
  }

  Status add(const Update& update) {
    v1::Update encoded = encode(update, aliases_);
    std::size_t bytes = encoded.ByteSizeLong();
    if (bytes_ > 0 && bytes_ + bytes > kMaxUpdateBytes) {
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
    const auto applied = send(connection_, request_);
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
    total_.nodes.insert(total_.nodes.end(), applied->nodes.begin(), applied->nodes.end());
    if (request_.has_expected_revision()) request_.set_expected_revision(applied->revision);
    request_.clear_updates();
    puts_.clear();
    bytes_ = 0;
    return {};
  }

  Applied take() { return std::move(total_); }

 private:
  const Connection& connection_;
  v1::ApplyUpdatesRequest request_;
  Aliases aliases_;
  std::vector<NodeRef> puts_;  // of the message being filled
  std::size_t bytes_ = 0;
  Applied total_;
};

// A long SetTransforms does not fit one message; its parts do.
Status add_in_parts(const SetTransforms& set, Batches& batches) {
  const std::size_t n = set.nodes.size();
  for (std::size_t first = 0; first < n; first += kTransformsPerUpdate) {
    const auto from = static_cast<std::ptrdiff_t>(first);
    const auto to = static_cast<std::ptrdiff_t>(std::min(n, first + kTransformsPerUpdate));
    SetTransforms part{{set.nodes.begin() + from, set.nodes.begin() + to},
                       {set.parent_from_local.begin() + from, set.parent_from_local.begin() + to}};
    if (Status added = batches.add(std::move(part)); !added) return added;
  }
  return {};
}

Status check(std::span<const Update> updates) {
  for (std::size_t i = 0; i < updates.size(); ++i) {
    const auto* set = std::get_if<SetTransforms>(&updates[i]);
    if (set == nullptr || set->nodes.size() == set->parent_from_local.size()) continue;
    return Error{Code::kInvalidArgument,
                 fmt::format("update {}: {} nodes but {} transforms", i, set->nodes.size(),
                             set->parent_from_local.size()),
                 {}};
  }
  return {};
}

}  // namespace

Result<Applied> apply(const Connection& connection, const std::string& scene,
                      std::span<const Update> updates, const ApplyOptions& options) {
  if (const Status checked = check(updates); !checked) return checked.error();
  const Aliases none;
  v1::ApplyUpdatesRequest request;
  request.set_scene(scene);
  if (options.expected_revision) request.set_expected_revision(*options.expected_revision);
  for (const Update& update : updates) *request.add_updates() = encode(update, none);
  if (const std::size_t bytes = request.ByteSizeLong(); bytes > kMaxMessageBytes) {
    return Error{Code::kResourceExhausted,
                 fmt::format("{} updates are {} bytes, of {} that one message may have",
                             updates.size(), bytes, kMaxMessageBytes),
                 {}};
  }
  return send(connection, request);
}

Result<Applied> apply_in_batches(const Connection& connection, const std::string& scene,
                                 std::span<const Update> updates, const ApplyOptions& options) {
  if (const Status checked = check(updates); !checked) return checked.error();
  Batches batches(connection, scene, options);
  for (const Update& update : updates) {
    const auto* set = std::get_if<SetTransforms>(&update);
    const bool is_long = set != nullptr && set->nodes.size() > kTransformsPerUpdate;
    const Status added = is_long ? add_in_parts(*set, batches) : batches.add(update);
    if (!added) return added.error();
  }
  if (const Status sent = batches.flush(); !sent) return sent.error();
  return batches.take();
}

}  // namespace sightline::client
