// Connects to the servers of the shards.
#include "server/shards/peers.h"

#include <fmt/format.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/support/channel_arguments.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "proto/printable.h"
#include "scenegraph/query/shard_cut.h"
#include "server/exec/rpc_status.h"
#include "server/exec/trace_context.h"
#include "server/net/listen_address.h"

namespace sightline::server::shards {
namespace {

constexpr std::uint32_t kFewestShards = 2;

Result<std::vector<net::ListenAddress>> parse(const std::string& addresses) {
  std::vector<net::ListenAddress> parsed;
  for (std::size_t at = 0; at <= addresses.size();) {
    const std::size_t end = std::min(addresses.find(',', at), addresses.size());
    auto address = net::ListenAddress::parse(std::string_view(addresses).substr(at, end - at));
    if (!address) return address.error();
    if (!address->is_unix() && address->port == 0)
      return exec::invalid_argument(fmt::format("shard peer {} has no port", address->text()),
                                    "BAD_SHARD_PEERS");
    const auto is_same = [&](const net::ListenAddress& other) {
      return other.text() == address->text();
    };
    if (std::any_of(parsed.begin(), parsed.end(), is_same))
      return exec::invalid_argument(fmt::format("shard peer {} is named twice", address->text()),
                                    "BAD_SHARD_PEERS");
    parsed.push_back(*std::move(address));
    at = end + 1;
  }
  if (parsed.size() < kFewestShards || parsed.size() > scenegraph::query::kMaxShards)
    return exec::invalid_argument(
        fmt::format("{} shard peers, but {} to {} are possible", parsed.size(), kFewestShards,
                    scenegraph::query::kMaxShards),
        "BAD_SHARD_PEERS");
  return parsed;
}

Result<std::string> read(const std::filesystem::path& file) {
  if (file.empty()) return std::string();
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in && !text.empty()) return text;
  return Error{Code::kFailedPrecondition, fmt::format("cannot read {}", file.string()),
               "FILE_NOT_READ"};
}

Result<std::shared_ptr<grpc::ChannelCredentials>> credentials(const PeerSettings& settings) {
  if (!settings.tls) return grpc::InsecureChannelCredentials();
  auto ca = read(settings.ca), certificate = read(settings.certificate), key = read(settings.key);
  for (const auto* text : {&ca, &certificate, &key}) {
    if (!*text) return text->error();
  }
  return grpc::SslCredentials({.pem_root_certs = *std::move(ca),
                               .pem_private_key = *std::move(key),
                               .pem_cert_chain = *std::move(certificate)});
}

/// A peer that returns is found again soon. One that is gone without a word is noticed over a
/// connection without calls, too, and such a connection is kept open where idle ones are cut.
grpc::ChannelArguments arguments() {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // a connection of its own
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 1000);  // time to connect
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 250);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 15'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return arguments;
}

}  // namespace

Status Peers::check(const PeerSettings& settings) {
  if (settings.addresses.empty()) return {};
  const auto addresses = parse(settings.addresses);
  return addresses ? Status() : Status(addresses.error());
}

Result<Peers> Peers::make(const PeerSettings& settings) {
  Peers peers;
  if (settings.addresses.empty()) return peers;
  const auto addresses = parse(settings.addresses);
  if (!addresses) return addresses.error();
  const auto called_with = credentials(settings);
  if (!called_with) return called_with.error();
  for (const net::ListenAddress& address : *addresses) {
    const std::string text = address.text();
    peers.peers_.push_back(std::make_unique<Peer>(text, [text, called_with = *called_with] {
      return grpc::CreateCustomChannel(text, called_with, arguments());
    }));
  }
  return peers;
}

void Peers::ping() const {
  for (const auto& peer : peers_) peer->ping();
}

Peer::Context Peers::context_for(const grpc::CallbackServerContext& caller) {
  Peer::Context context = grpc::ClientContext::FromCallbackServerContext(caller);
  for (const char* const header : {"authorization", exec::kRequestId, exec::kTraceParent}) {
    const auto [first, last] = caller.client_metadata().equal_range(header);
    for (auto at = first; at != last; ++at) {
      const std::string value(at->second.data(), at->second.size());
      if (is_printable(value)) context->AddMetadata(header, value);
    }
  }
  return context;
}

}  // namespace sightline::server::shards
