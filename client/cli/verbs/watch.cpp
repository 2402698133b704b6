// sightline watch: prints the changes of a scene as they happen.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "client/cli/files/update_json.h"
#include "client/cli/flags.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct WatchArguments {
  std::string scene;
  std::optional<std::uint64_t> from;
  std::uint64_t count = 0;
  bool positions = false;
};

// Returns false if the reader of stdout is gone.
bool print_line(const SceneChange& change, bool positions) {
  Json updates = Json::array();
  for (const Update& update : change.updates) updates.push_back(files::json_of(update, positions));
  const Json line{
      {"revision", change.revision}, {"token", change.token}, {"updates", std::move(updates)}};
  const std::string text = json_text(line, -1) + "\n";
  return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() &&
         std::fflush(stdout) == 0;
}

ExitCode watch(const Session& session, const WatchArguments& arguments) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const Interrupt interrupt;
  std::uint64_t seen = 0;
  const SceneChangeSink sink = [&](const SceneChange& change) {
    if (change.is_progress) return true;
    return print_line(change, arguments.positions) && ++seen != arguments.count;
  };
  const Status watched = client->watch(arguments.scene, arguments.from, sink, interrupt.token());
  if (interrupt.happened()) return say_interrupted();
  return watched ? kOk : fail(watched.error());
}

constexpr const char* kWatchFooter =
    R"(A line is {"revision": N, "token": ..., "updates": [...]}, with updates as `sightline update` takes them; of patched
vertices only the number, unless --positions asks for them. Goes on until Ctrl-C, which ends with exit code 130, and
through broken connections. A revision that is no longer kept is an error: begin anew, from what `scene show` says.

Examples:
  sightline watch hall
  sightline watch hall --from 0 --count 10 | jq -c .updates[])";

}  // namespace

void add_watch_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("watch", "Follow what happens to a scene");
  const auto arguments = std::make_shared<WatchArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("--from", arguments->from,
                  "Tell of all revisions after this one (default: after the current one)")
      ->type_name("N");
  verb.add_option("--count", arguments->count, "End after so many revisions")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("N");
  verb.add_flag("--positions", arguments->positions, "Print the vertices that are patched");
  verb.footer(kWatchFooter);
  verb.callback([&session, arguments] { session.exit = watch(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs
