// sightline backup and restore.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "client/cli/flags.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct BackupArguments {
  std::string directory;
  std::string scene;  // empty: all
  std::string since;  // empty: no earlier backup
  std::uint64_t revision = 0;
};

ExitCode back_up(const Session& session, const BackupArguments& arguments) {
  const Interrupt interrupt;
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scenes = client->backup(
      arguments.directory,
      {.scene = arguments.scene, .since = arguments.since, .stop = interrupt.token()});
  if (!scenes && interrupt.happened()) return say_interrupted();
  if (!scenes) return fail(scenes.error());
  if (session.json) {
    Json rows = Json::array();
    for (const BackupScene& scene : *scenes)
      rows.push_back({{"scene", scene.name}, {"base", scene.base}, {"revision", scene.revision}});
    print_json({{"directory", arguments.directory}, {"scenes", rows}});
    return kOk;
  }
  if (session.quiet) return kOk;
  for (const BackupScene& scene : *scenes)
    fmt::print("{} at revision {}; it can be restored from revision {} on\n", printable(scene.name),
               scene.revision, scene.base);
  return kOk;
}

ExitCode restore(const Session& session, const BackupArguments& arguments) {
  const Interrupt interrupt;
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scenes = client->restore(
      arguments.directory,
      {.scene = arguments.scene, .revision = arguments.revision, .stop = interrupt.token()});
  if (!scenes && interrupt.happened()) return say_interrupted();
  if (!scenes) return fail(scenes.error());
  if (session.json) {
    Json rows = Json::array();
    for (const RestoredScene& scene : *scenes)
      rows.push_back({{"scene", scene.name}, {"revision", scene.revision}});
    print_json({{"directory", arguments.directory}, {"scenes", rows}});
    return kOk;
  }
  if (session.quiet) return kOk;
  for (const RestoredScene& scene : *scenes)
    fmt::print("{} restored at revision {}\n", printable(scene.name), scene.revision);
  return kOk;
}

constexpr const char* kBackupFooter =
    R"(The directory must be empty or missing. Writers go on: each scene is copied as it is when its turn comes.

With --since the sums of the earlier backup are compared first. Its files of meshes that the server still has become hard
links, or copies on another file system: each backup is whole, and either may be deleted.

Examples:
  sightline backup /var/backups/sightline/monday
  sightline backup /var/backups/sightline/tuesday --since /var/backups/sightline/monday
  sightline backup engine-only --scene engine)";

constexpr const char* kRestoreFooter =
    R"(Scenes of the backup take the place of those with the same names; others stay. A restored scene is a new one:
tokens of before are not valid, and producers begin anew.

Examples:
  sightline restore /var/backups/sightline/monday
  sightline restore monday --scene engine --revision 120)";

CLI::App& add_verb(CLI::App& program, const char* name, const char* help, Session& session,
                   const std::shared_ptr<BackupArguments>& arguments,
                   ExitCode (*run)(const Session&, const BackupArguments&)) {
  CLI::App& verb = *program.add_subcommand(name, help);
  verb.add_option("DIR", arguments->directory, "A directory of this machine")->required();
  add_scene_option(verb, arguments->scene);
  verb.callback([&session, arguments, run] { session.exit = run(session, *arguments); });
  return verb;
}

}  // namespace

void add_backup_verbs(CLI::App& program, Session& session) {
  const auto copied = std::make_shared<BackupArguments>();
  CLI::App& backup = add_verb(program, "backup", "Copy the server's scenes to a directory", session,
                              copied, back_up);
  backup
      .add_option("--since", copied->since,
                  "An earlier backup: what it has of meshes is linked, and not sent again")
      ->type_name("DIR");
  backup.footer(kBackupFooter);
  const auto arguments = std::make_shared<BackupArguments>();
  CLI::App& verb =
      add_verb(program, "restore", "Put the scenes of a backup back", session, arguments, restore);
  verb.add_option("--revision", arguments->revision,
                  "The scenes as they were at this revision (default: the newest)")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("N");
  verb.footer(kRestoreFooter);
}

}  // namespace sightline::client::cli::verbs
