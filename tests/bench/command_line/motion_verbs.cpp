// Verbs that move a scene, or ask a server.
#include <memory>

#include "client/cast_options.h"
#include "tests/bench/command_line/shared_options.h"

namespace sightline::bench {
namespace {

Verb add_verb_dynamic(CLI::App& app) {
  auto options = std::make_shared<DynamicOptions>();
  CLI::App& verb = *app.add_subcommand(
      "dynamic", "Frames of a scene that moves over one that stands still, a row a frame");
  verb.add_option("--frames", options->frames,
                  "A directory of meshes of one topology, or gen:swarm?triangles=")
      ->required();
  verb.add_option("--copies", options->copies, "Of a directory's meshes, side by side")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000}));
  verb.add_option("--static", options->static_scene,
                  "A scene: ten times as large, under what moves");
  verb.add_option("--static-small", options->small_static_scene,
                  "Another, over which the frames are played too, for comparison");
  add_rays(verb, options->rays);
  verb.add_flag("--shadow", options->shadow, "And a ray toward a light from every hit");
  verb.add_option("--view", options->view, "What the rays are made for: scene|frames");
  verb.add_option("--length", options->length, "Frames to play (default: each once)")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000}));
  verb.add_option("--peers", options->peers, "embree-low,embree-refit")->delimiter(',');
  return [options](const CommonOptions& common) { return run_dynamic(common, *options); };
}

Verb add_verb_two_trees(CLI::App& app) {
  auto options = std::make_shared<TwoTreesOptions>();
  CLI::App& verb = *app.add_subcommand(
      "two-trees", "What it costs that rays visit a static and a dynamic tree instead of one");
  add_rays(verb, options->rays);
  verb.add_option("--parts", options->parts, "Balls that are spread through the scene")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000}));
  return [options](const CommonOptions& common) { return run_two_trees(common, *options); };
}

Verb add_verb_updates(CLI::App& app) {
  auto options = std::make_shared<UpdatesOptions>();
  CLI::App& verb = *app.add_subcommand(
      "updates", "What a batch of updates costs, by kind, over the size of the scene");
  verb.add_option("--nodes", options->nodes, "Sizes of the scene")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{10}, std::size_t{10'000'000}));
  verb.add_option("--items", options->items, "Nodes that the larger batches name")
      ->check(CLI::Range(std::size_t{2}, std::size_t{65'536}));
  return [options](const CommonOptions& common) { return run_updates(common, *options); };
}

Verb add_verb_scattered(CLI::App& app) {
  auto options = std::make_shared<ScatteredOptions>();
  CLI::App& verb = *app.add_subcommand(
      "scattered", "Revisions that move nodes all over a large scene, by rules for merging trees");
  const CLI::Range any(std::size_t{1}, std::size_t{10'000'000});
  verb.add_option("--nodes", options->scene.nodes, "That have a mesh")->check(any);
  verb.add_option("--groups", options->scene.groups, "They are in; 0: all are roots")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1'000'000}));
  verb.add_option("--count", options->moving, "Nodes that a revision moves")->check(any);
  verb.add_option("--moving", options->moved, "same|random: the same nodes each time, or any")
      ->check(CLI::IsMember({"same", "random"}));
  verb.add_option("--revisions", options->revisions, "How many")->check(any);
  verb.add_option("--casts", options->casts, "After each revision")->check(any);
  verb.add_option("--rays", options->rays, "A cast")->check(any);
  verb.add_option("--warm", options->warm, "Casts before the first revision")->check(any);
  verb.add_option("--small-tree", options->small_trees, "MergeRule::small_tree, by commas")
      ->delimiter(',');
  verb.add_option("--at-once", options->at_once, "MergeRule::at_once, by commas")->delimiter(',');
  return [options](const CommonOptions& common) { return run_scattered(common, *options); };
}

Verb add_verb_remote(CLI::App& app) {
  auto options = std::make_shared<RemoteOptions>();
  CLI::App& verb = *app.add_subcommand(
      "remote", "What it costs to ask a server: processor time, throughput, latency");
  add_rays(verb, options->rays);
  verb.add_option("--clients", options->clients, "Each with a stream of its own")
      ->check(CLI::Range(1, 64));
  verb.add_option("--batch", options->batch, "Rays of a message")
      ->check(CLI::Range(std::size_t{1}, client::kRaysPerMessage));
  verb.add_option(
          "--columns", options->columns,
          "rich,t,bits,generated: all of a hit, t, whether there is one, and the same of rays "
          "that the server makes")
      ->delimiter(',')
      ->check(CLI::IsMember({"rich", "t", "bits", "generated"}));
  verb.add_flag("--points", options->points,
                "The faces nearest to the rays' origins instead; none of generated rays");
  verb.add_flag("--segments", options->segments,
                "By one client at a Unix socket, through memory that it shares with the server");
  verb.add_flag("--echo", options->echo, "And casts of one ray beside an echo service");
  return [options](const CommonOptions& common) { return run_remote(common, *options); };
}

Verb add_verb_tick(CLI::App& app) {
  auto options = std::make_shared<TickOptions>();
  CLI::App& verb = *app.add_subcommand(
      "tick", "Ticks of a game at a server: agents move, and rays say what they see");
  verb.add_option("--agents", options->agents, "Cubes that move each tick")
      ->check(CLI::Range(std::size_t{1}, std::size_t{10'000}));
  verb.add_option("--rays", options->rays, "Any-hit rays of a tick")
      ->check(CLI::Range(std::size_t{1}, client::kRaysPerMessage));
  verb.add_option("--ticks", options->ticks, "How many of each way")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000}));
  verb.add_option("--rate", options->rate, "Ticks a second")->check(CLI::Range(1.0, 1e4));
  return [options](const CommonOptions& common) { return run_tick(common, *options); };
}

}  // namespace

Verbs add_motion_verbs(CLI::App& app) {
  return {{"dynamic", add_verb_dynamic(app)}, {"two-trees", add_verb_two_trees(app)},
          {"updates", add_verb_updates(app)}, {"scattered", add_verb_scattered(app)},
          {"remote", add_verb_remote(app)},   {"tick", add_verb_tick(app)}};
}

}  // namespace sightline::bench
