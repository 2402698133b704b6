// sightline update: applies changes from a file to a scene.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/files/update_file.h"
#include "client/cli/flags.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct UpdateArguments {
  std::string scene;
  std::string file;
  std::optional<std::uint64_t> expected_revision;
  std::string request_id;
  bool in_parts = false;
};

constexpr std::size_t kMaxRequestId = 48;  // bytes

void report(const Session& session, const UpdateArguments& arguments, std::size_t updates,
            const Applied& applied) {
  if (session.json) {
    print_json({{"scene", arguments.scene},
                {"revision", applied.revision},
                {"updates", updates},
                {"nodes", applied.nodes},
                {"token", applied.token},
                {"replayed", applied.replayed}});
    return;
  }
  if (session.quiet) return;
  fmt::print("{} at revision {}: {} update{}{}\n", arguments.scene, applied.revision, updates,
             updates == 1 ? "" : "s", applied.replayed ? ", applied before" : "");
  if (!applied.nodes.empty()) fmt::print("  nodes  {}\n", fmt::join(applied.nodes, " "));
  fmt::print("  token  {}\n", printable(applied.token));
}

ExitCode run(const Session& session, const UpdateArguments& arguments) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto updates = [&] {
    const Interrupt interrupt;  // while waiting for standard input
    return files::read_updates(arguments.file, interrupt.token());
  }();
  if (!updates && updates.error().code == Code::kCancelled) return say_interrupted();
  if (!updates) return fail(updates.error());
  const ApplyOptions options{arguments.expected_revision, arguments.request_id};
  const auto applied = arguments.in_parts
                           ? client->apply_in_batches(arguments.scene, *updates, options)
                           : client->apply(arguments.scene, *updates, options);
  if (!applied) return fail(applied.error());
  report(session, arguments, updates->size(), *applied);
  return kOk;
}

constexpr const char* kUpdateFooter =
    R"(A line is a JSON object of one key, and what it takes is what the messages of the API take:
  {"put_node": {"node": -1, "parent": 0, "name": "box", "transform": [12 numbers], "mesh_digest": "sha256:...",
                "mobility": "static|rigid|deforming", "mask": 4294967295}}
  {"set_transforms": {"nodes": [3, 4], "matrices": [[12 numbers], [12 numbers]]}}
  {"patch_vertices": {"nodes": [3], "first": 0, "positions": [[x, y, z], ...]}}
  {"delete_node": {"node": 3, "subtree": true}}
Nodes are named by their ids (> 0) or, after the put_node that makes them, by its negative number. A transform is 3
rows of 4, or 4 with 0 0 0 1 as the last, parent from local. All lines are one batch: all or nothing, and one revision.

Examples:
  sightline update hall --file ops.ndjson
  echo '{"delete_node": {"node": 7}}' | sightline update hall --file - --expect-revision 12
  sightline update hall --file ops.ndjson --request-id night-shift-7 --json)";

}  // namespace

void add_update_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("update", "Change a scene's nodes, from a file");
  const auto arguments = std::make_shared<UpdateArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("--file", arguments->file, "Updates, one a line; - is standard input")
      ->required()
      ->type_name("OPS.ndjson");
  verb.add_option("--expect-revision", arguments->expected_revision,
                  "Do nothing, with exit code 4, unless the scene is at this revision")
      ->type_name("N");
  verb.add_option("--request-id", arguments->request_id,
                  "A name for this request: repeated, it changes nothing and gets the first answer")
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            return text.empty() || text.size() > kMaxRequestId ? "must have 1 to 48 bytes" : "";
          },
          ""))
      ->type_name("ID");
  verb.add_flag("--in-parts", arguments->in_parts,
                "More than one message holds: several batches, each a revision");
  verb.footer(kUpdateFooter);
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs
