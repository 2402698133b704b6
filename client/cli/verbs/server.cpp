// sightline server: what the server says of itself.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "client/cli/terminal.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

Json json_of(const std::vector<HeldBytes>& held) {
  Json json = Json::object();
  for (const HeldBytes& one : held) json[printable(one.kind)] = one.bytes;
  return json;
}

/// "meshes 12 MB, trees 3 MB": what is not nothing.
std::string text_of(const std::vector<HeldBytes>& held) {
  std::string text;
  for (const HeldBytes& one : held) {
    if (one.bytes == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", printable(one.kind),
                        format_bytes(one.bytes));
  }
  return text.empty() ? "nothing" : text;
}

Json json_of(const Session& session, const ServerInfo& info) {
  return {{"endpoint", session.endpoint},
          {"version", info.version},
          {"policy", info.policy},
          {"threads", info.threads},
          {"simd_target", info.simd_target},
          {"durable", info.is_durable},
          {"features", info.features},
          {"memory_budget_bytes", info.memory_budget_bytes},
          {"memory_bytes", json_of(info.memory)},
          {"tree_memory_bytes", json_of(info.tree_memory)},
          {"tree_pieces_evicted", info.tree_pieces_evicted},
          {"tree_bytes_evicted", info.tree_bytes_evicted},
          {"max_scenes", info.max_scenes},
          {"max_connections", info.max_connections},
          {"max_message_bytes", info.max_message_bytes},
          {"max_rays_per_request", info.max_rays_per_request},
          {"max_rays_per_shared_request", info.max_rays_per_shared_request},
          {"max_segment_bytes", info.max_segment_bytes},
          {"max_segments", info.max_segments},
          {"max_segments_per_principal", info.max_segments_per_principal},
          {"max_rays_queued", info.max_rays_queued},
          {"max_triangles_per_mesh", info.max_triangles_per_mesh},
          {"max_depth", info.max_depth},
          {"max_hits_per_ray", info.max_hits_per_ray},
          {"max_exclusions", info.max_exclusions},
          {"max_updates_per_batch", info.max_updates_per_batch}};
}

void print_table(const Session& session, const ServerInfo& info) {
  fmt::print("sightlined {} at {}\n", printable(info.version), printable(session.endpoint));
  fmt::print("  scenes     {}, at most {}\n",
             info.is_durable ? "kept on disk" : "kept in memory only",
             format_count(info.max_scenes));
  fmt::print("  memory     {} at most\n", format_bytes(info.memory_budget_bytes));
  fmt::print("  held       {}\n", text_of(info.memory));
  fmt::print("  of trees   {}\n", text_of(info.tree_memory));
  fmt::print("  evicted    {} pieces of trees, {}\n", format_count(info.tree_pieces_evicted),
             format_bytes(info.tree_bytes_evicted));
  fmt::print("  threads    {}, {}\n", info.threads, printable(info.simd_target));
  fmt::print("  trees      {}\n", printable(info.policy));
  fmt::print("  a request  {} rays at most\n", format_count(info.max_rays_per_request));
  fmt::print("  clients    {} at most\n", format_count(info.max_connections));
}

ExitCode run(const Session& session) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto info = client->server_info();
  if (!info) return fail(info.error());
  if (session.json) {
    print_json(json_of(session, *info));
  } else {
    print_table(session, *info);
  }
  return kOk;
}

}  // namespace

void add_server_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("server", "What the server says of itself");
  verb.footer(
      "Examples:\n  sightline server\n  sightline server --json | jq .max_rays_per_request");
  verb.callback([&session] { session.exit = run(session); });
}

}  // namespace sightline::client::cli::verbs
