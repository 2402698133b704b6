// sightline stream: plays an animation into a scene.
#include "client/cli/verbs/verbs.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/nodes.h"
#include "client/cli/playback/motion.h"
#include "client/cli/playback/playback.h"
#include "client/cli/playback/target.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/import_warnings.h"

namespace sightline::client::cli::verbs {
namespace {

bool is_producer_name(const std::string& text) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), is_plain);
}

struct StreamArguments {
  playback::TargetRequest target;
  playback::MotionRequest motion;
  playback::PlaybackRequest playback;
  std::optional<double> seconds;
  std::optional<std::uint64_t> loops;
  std::optional<std::uint64_t> frame;
  std::optional<double> time;
};

// Up to this number, a double counts frames exactly.
constexpr double kMostFrames = 0x1p+53;

std::uint64_t whole(double frames) {
  return static_cast<std::uint64_t>(std::min(frames, kMostFrames));
}

// The number of frames in one round or several. The last moment of a cyclic motion is the first of
// the next round.
std::uint64_t frames_in(const StreamArguments& arguments, const playback::Motion& motion) {
  if (arguments.frame || arguments.time) return 1;
  const double fps = arguments.playback.fps;
  if (arguments.seconds) return whole(std::max(1.0, std::ceil(*arguments.seconds * fps - 1e-6)));
  const std::uint64_t rounds = arguments.loops.value_or(1);
  const double frames = static_cast<double>(rounds) * motion.seconds * fps;
  if (motion.is_cyclic) return whole(std::round(frames));
  return rounds == 0 ? 0 : whole(std::floor(frames + 1e-6)) + 1;
}

// The time within a round that frame k shows.
double moment_of(std::uint64_t k, const StreamArguments& arguments,
                 const playback::Motion& motion) {
  double seconds = static_cast<double>(k) / arguments.playback.fps;
  if (arguments.frame) seconds = static_cast<double>(*arguments.frame) / arguments.playback.fps;
  if (arguments.time) seconds = *arguments.time;
  if (!(motion.seconds > 0) || seconds < motion.seconds) return seconds;
  const double rest = std::fmod(seconds, motion.seconds);
  return rest == 0 && !motion.is_cyclic ? motion.seconds : rest;
}

Result<playback::Motion> read_motion(const StreamArguments& arguments) {
  ProgressBar bar("reading");
  return open_motion(arguments.motion, [&](double part) { bar.update(part); });
}

Result<playback::PlaybackReport> play_motion(const Client& client, const StreamArguments& arguments,
                                             const playback::Motion& motion,
                                             const playback::PlaybackTarget& target,
                                             const std::stop_token& stop) {
  playback::PlaybackRequest request = arguments.playback;
  request.scene = arguments.target.scene;
  request.frames = frames_in(arguments, motion);
  request.stop = stop;
  if (request.producer.empty()) request.producer = fmt::format("stream-{}", target.first_moved);
  playback::FrameUpdates frames(target.ids);
  ProgressBar bar("playing");
  return playback::play(
      client, request,
      [&](std::uint64_t frame, bool afresh) {
        if (afresh) frames.forget();
        return frames.make(motion.pose(moment_of(frame, arguments, motion)));
      },
      [&](std::uint64_t frame) {
        const double part = static_cast<double>(frame + 1) /
                            static_cast<double>(std::max(request.frames, frame + 1));
        bar.update(part, fmt::format("frame {}", frame));
      });
}

Json json_of(const StreamArguments& arguments, const playback::Motion& motion,
             const playback::PlaybackTarget& target, const playback::PlaybackReport& report,
             bool complete) {
  return {{"scene", arguments.target.scene},
          {"animation", motion.name},
          {"imported", target.is_new},
          {"nodes_moved", target.placed},
          {"meshes_deformed", target.shaped},
          {"frames_sent", report.frames_sent},
          {"frames_unchanged", report.frames_unchanged},
          {"frames_late", report.frames_late},
          {"frames_dropped", report.frames_dropped},
          {"seconds", report.seconds},
          {"fps_asked", arguments.playback.fps},
          {"fps_achieved", report.fps_achieved},
          {"ack_p50_ms", playback::percentile(report.ack_ms, 0.5)},
          {"ack_p99_ms", playback::percentile(report.ack_ms, 0.99)},
          {"coalesced", report.stream.coalesced},
          {"rejected", report.stream.rejected},
          {"reconnects", report.stream.reconnects},
          {"bytes_sent", report.stream.bytes_sent},
          {"revision", report.stream.revision},
          {"token", report.stream.token},
          {"warnings", json_of_warnings(motion.scene.warnings)},
          {"complete", complete}};
}

void print_table(std::FILE* to, const StreamArguments& arguments,
                 const playback::PlaybackReport& report) {
  fmt::print(to, "{} at revision {}: {} frames in {:.2f} s", arguments.target.scene,
             report.stream.revision, format_count(report.frames_sent), report.seconds);
  if (report.fps_achieved > 0)
    fmt::print(to, ", {:.1f} a second of {:g}", report.fps_achieved, arguments.playback.fps);
  fmt::print(to, "\n  answers    after {:.2f} ms (median), {:.2f} ms (99 of 100)\n",
             playback::percentile(report.ack_ms, 0.5), playback::percentile(report.ack_ms, 0.99));
  fmt::print(to, "  skipped    {} late, {} dropped, {} coalesced, {} unchanged\n",
             report.frames_late, report.frames_dropped, report.stream.coalesced,
             report.frames_unchanged);
  if (report.stream.rejected > 0) fmt::print(to, "  rejected   {}\n", report.stream.rejected);
  if (report.stream.reconnects > 0) fmt::print(to, "  reconnects {}\n", report.stream.reconnects);
  fmt::print(to, "  sent       {}\n", format_bytes(report.stream.bytes_sent));
  fmt::print(to, "  token      {}\n", printable(report.stream.token));
}

ExitCode report(const Session& session, const StreamArguments& arguments,
                const playback::Motion& motion, const playback::PlaybackTarget& target,
                const playback::PlaybackReport& report, bool complete) {
  if (session.json) print_json(json_of(arguments, motion, target, report, complete));
  if (!complete) {
    if (!session.quiet) print_table(stderr, arguments, report);
    return interrupted_code();
  }
  if (!session.json && !session.quiet) print_table(stdout, arguments, report);
  return report.first_reject ? fail(*report.first_reject) : kOk;
}

ExitCode run(const Session& session, StreamArguments& arguments) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scene = client->get_scene(arguments.target.scene);
  if (!scene && scene.error().code != Code::kNotFound) return fail(scene.error());
  if (scene) arguments.motion.frame = playback::frame_of(*scene);
  const auto motion = read_motion(arguments);
  if (!motion) return fail(motion.error());
  print_import_warnings(motion->scene.warnings);
  const Interrupt interrupt;
  const auto target =
      playback::prepare_target(*client, arguments.target, *motion, scene.ok(), interrupt.token());
  if (!target && interrupt.happened()) return say_interrupted();
  if (!target) return fail(target.error());
  const auto played = play_motion(*client, arguments, *motion, *target, interrupt.token());
  if (!played) return fail(played.error());
  return report(session, arguments, *motion, *target, *played, !interrupt.happened());
}

constexpr const char* kStreamFooter =
    R"(FILE is glTF or Collada with an animation of nodes, skins or shapes; a folder is a sequence of meshes with one
topology, a file a frame, in the order of their names. A scene that is not there is imported first. One that is there
must have been imported from that very FILE (of a folder, from its first file), or holds it since an earlier --add:
nodes are found by their names, below one another as in FILE.

Frame k is due k / fps after the first. Frames that cannot go out in time are skipped, but the last is always sent.
Ctrl-C ends the stream well, when what was sent has been answered, with exit code 130.

Examples:
  sightline stream robot --animate brainstem.glb
  sightline stream horse --animate horse_gallop --fps 24 --loops 0 --latest-wins
  sightline stream hall --animate truck.glb --add --seconds 10 --json
  sightline stream truck --animate truck.glb --time 0.5)";

void add_choice_of_frames(CLI::App& verb, StreamArguments& arguments) {
  CLI::Option* const seconds = verb.add_option("--seconds", arguments.seconds, "How long to play")
                                   ->check(positive_number())
                                   ->type_name("S");
  CLI::Option* const loops = verb.add_option("--loops", arguments.loops,
                                             "How many rounds to play, 0: until Ctrl-C (default 1)")
                                 ->excludes(seconds)
                                 ->type_name("N");
  CLI::Option* const frame =
      verb.add_option("--frame", arguments.frame, "Send this one frame, from 0, and no other")
          ->excludes(seconds)
          ->excludes(loops)
          ->type_name("K");
  verb.add_option("--time", arguments.time, "Send the pose of this moment, and no other")
      ->excludes(seconds)
      ->excludes(loops)
      ->excludes(frame)
      ->check(CLI::NonNegativeNumber.description(""))
      ->type_name("SECONDS");
}

}  // namespace

void add_stream_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("stream", "Play an animation into a scene");
  const auto arguments = std::make_shared<StreamArguments>();
  add_scene_argument(verb, arguments->target.scene);
  verb.add_option("--animate", arguments->motion.path, "What to play")
      ->required()
      ->type_name("FILE|DIR");
  verb.add_option("--animation", arguments->motion.animation,
                  "Which animation of the file, by name or number (default: its first)")
      ->type_name("NAME|INDEX");
  verb.add_option("--fps", arguments->playback.fps, "Frames a second (default 30)")
      ->check(positive_number())
      ->type_name("N");
  add_choice_of_frames(verb, *arguments);
  verb.add_flag("--latest-wins,--at-most-latest", arguments->playback.latest_wins,
                "Frames that wait at the server may be passed over for newer ones");
  CLI::Option* const add =
      verb.add_flag("--add", arguments->target.add,
                    "Put FILE's nodes into the scene first, beside what it holds");
  verb.add_option("--under", arguments->target.under, "FILE's nodes are below this node")
      ->check(node_word())
      ->type_name("NODE");
  verb.add_flag("--create,--import", arguments->target.must_be_new,
                "The scene must not be there yet")
      ->excludes(add);
  verb.add_option("--node", arguments->target.only,
                  "Only these nodes move, by id, or by name in FILE (default: all that do)")
      ->type_name("ID|NAME ...");
  verb.add_option(
          "--producer", arguments->playback.producer,
          "The stream's name in the scene; one of that name is taken over (default: stream-ID, of "
          "the first node that moves)")
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            return is_producer_name(text)
                       ? ""
                       : "'" + text + "' is no name: 1 to 64 of A-Z a-z 0-9 . _ -";
          },
          ""))
      ->type_name("NAME");
  verb.footer(kStreamFooter);
  verb.callback([&session, arguments] {
    arguments->motion.fps = arguments->playback.fps;
    session.exit = run(session, *arguments);
  });
}

}  // namespace sightline::client::cli::verbs
