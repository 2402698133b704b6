// dynamic: frames of a moving scene over a static one: update, grow on demand, trace.
#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "tests/bench/scenes/load_scene.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/dynamic_show.h"
#include "tests/bench/verbs/stopwatch.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

// The wall time of growing is only known as a share of all threads' time; other waiting of a
// frame's first rays counts as tracing.
Status play(const Show& show, std::size_t frame, Ours& ours, Seen& seen) {
  const auto updated = ours.stage->advance(show.motion, frame);
  if (!updated.ok()) return updated.error();
  ours.stats = {};
  const auto first = look(ours.stage->now(), show.view, seen, ours.stats);
  if (!first.ok()) return first.error();
  const double build = ours.stats.build_seconds / show.threads;
  ours.costs.push_back({*updated * 1e3, build * 1e3, (*first - build) * 1e3});
  Seen again;
  scenegraph::TraceStats unused;
  const auto second = look(ours.stage->now(), show.view, again, unused);
  if (!second.ok()) return second.error();
  ours.again.push_back(*second * 1e3);
  if (again.hash() == seen.hash()) return {};
  return Error{Code::kDataLoss, fmt::format("answers of frame {} change as trees grow", frame),
               "HASHES_DIFFER"};
}

// The same rays. Rays toward the light are those of the whole scene.
Status trace_static(const FrameView& view, const Seen& seen, StaticPart& part) {
  if (!part.snapshot) return {};
  const FrameView primary{view.rays, false, {}};
  Seen alone;
  scenegraph::TraceStats unused;
  const auto first = look(*part.snapshot, primary, alone, unused);
  if (!first.ok()) return first.error();
  double seconds = *first;
  if (view.shadow) {
    std::vector<accel::geometry::Hit> hits(seen.shadow_rays.size());
    const Stopwatch clock;
    const auto traced = scenegraph::trace(*part.snapshot, seen.shadow_rays, hits,
                                          {.kind = scenegraph::QueryKind::kAny, .surface = false});
    seconds += clock.seconds();
    if (!traced.ok()) return traced.error();
  }
  part.trace.push_back(seconds * 1e3);
  return {};
}

// Grows the static part beforehand, so that touches of it in later frames are not first views.
Status look_behind(const Show& show) {
  for (const Ours* ours : {&show.ours, &show.small}) {
    if (!ours->stage) continue;
    if (Status s = ours->stage->look_behind(show.motion, show.view.rays); !s.ok()) return s;
  }
  return {};
}

Status play_peer(const Show& show, std::size_t frame, const Seen& seen, Peer& peer) {
  const auto advanced = peer.embree->advance(frame);
  if (!advanced.ok()) return advanced.error();
  peer.hits.resize(show.view.rays.size());
  double trace = peer.embree->trace(show.view.rays, false, peer.hits);
  if (show.view.shadow) {
    peer.shadowed.resize(seen.shadow_rays.size());
    if (frame == 0) peer.embree->choose_any(seen.shadow_rays);
    trace += peer.embree->trace(seen.shadow_rays, true, peer.shadowed);
  }
  peer.costs.push_back(
      {advanced->update_seconds * 1e3, advanced->build_seconds * 1e3, trace * 1e3});
  return {};
}

// Answers that are compared with a new scene after all frames have been played.
struct Kept {
  std::size_t frame;
  Seen seen;
  std::vector<std::vector<accel::geometry::Hit>> of_peers;
};

Status check_kept(Show& show, const std::vector<Kept>& kept) {
  for (const Kept& k : kept) {
    const auto fresh = check_frame(show.staged, show.motion, k.frame, show.view, k.seen);
    if (!fresh.ok()) return fresh.error();
    for (std::size_t p = 0; p < show.peers.size(); ++p) {
      const Disagreement d = explain(*fresh, show.view.rays, k.seen.hits, k.of_peers[p], false);
      show.peers[p].disagreement.differences += d.differences;
      show.peers[p].disagreement.checked += d.checked;
      show.peers[p].disagreement.unexplained += d.unexplained;
    }
  }
  return {};
}

Result<std::vector<Row>> play_all(const CommonOptions& common, const DynamicOptions& options,
                                  Show& show) {
  const std::size_t length = options.length > 0 ? options.length : show.motion.frames();
  std::vector<Row> rows;
  std::vector<Kept> kept;
  for (std::size_t frame = 0; frame < length; ++frame) {
    Seen seen, of_small;
    if (Status s = play(show, frame, show.ours, seen); !s.ok()) return s.error();
    if (Status s = trace_static(show.view, seen, show.static_part); !s.ok()) return s.error();
    if (show.small.stage) {
      if (Status s = play(show, frame, show.small, of_small); !s.ok()) return s.error();
    }
    for (Peer& peer : show.peers) {
      if (Status s = play_peer(show, frame, seen, peer); !s.ok()) return s.error();
    }
    rows.push_back(frame_row(show, frame, seen));
    if (frame == 0) {
      if (Status s = look_behind(show); !s.ok()) return s.error();
    }
    if (frame != 0 && frame != length / 2 && frame + 1 != length) continue;
    kept.push_back({frame, std::move(seen), {}});
    for (const Peer& peer : show.peers) kept.back().of_peers.push_back(peer.hits);
  }
  if (Status right = check_kept(show, kept); !right.ok()) return right.error();
  rows.push_back(last_row(common, options, show, rows));
  return rows;
}

Result<StagedScene> stage(const std::string& static_scene, const Motion& motion) {
  if (static_scene.empty()) return StagedScene::make(motion);
  auto source = load_scene(static_scene);
  if (!source.ok()) return source.error();
  return StagedScene::make(std::move(source).value(), motion);
}

Result<std::vector<Peer>> open_peers(const DynamicOptions& options, const StagedScene& staged,
                                     const Motion& motion, const FrameView& view, int threads) {
  std::vector<Peer> peers;
  for (const std::string& name : options.peers) {
    const bool refit = name == "embree-refit";
    if (!refit && name != "embree-low") {
      return Error{Code::kInvalidArgument,
                   fmt::format("no peer \"{}\"; there are: embree-low embree-refit", name),
                   "COMMAND_LINE"};
    }
    if (embree_is_missing(name)) continue;
    auto embree = EmbreeDynamicPeer::make(
        staged, motion, refit ? EmbreeUpdate::kRefit : EmbreeUpdate::kRebuild, threads);
    if (!embree.ok()) return embree.error();
    if (Status chosen = (*embree)->choose(view.rays); !chosen.ok()) return chosen.error();
    peers.push_back(
        {refit ? "embree_refit" : "embree_low", std::move(embree).value(), {}, {}, {}, {}});
  }
  return peers;
}

}  // namespace

Result<std::vector<Row>> run_dynamic(const CommonOptions& common, const DynamicOptions& options) {
  if (auto p = parse_policy(common.policy, scenegraph::Growth::kFirstTouch); !p.ok()) {
    return p.error();
  } else if (*p != scenegraph::Growth::kFirstTouch) {
    return Error{Code::kInvalidArgument, "frames are traced with policy first-touch",
                 "COMMAND_LINE"};
  }
  const auto builder = configured_builder({}, common);
  if (!builder.ok()) return builder.error();
  const auto motion = Motion::make(options.frames, options.copies);
  if (!motion.ok()) return motion.error();
  const auto staged = stage(options.static_scene, *motion);
  if (!staged.ok()) return staged.error();
  const auto view = FrameView::make(*staged, *motion, options, common.seed);
  if (!view.ok()) return view.error();

  Show show{*motion, *staged, *view, common.threads, {}, {}, {}, {}};
  auto live = LiveStage::make(*staged, *builder);
  if (!live.ok()) return live.error();
  show.ours.stage = std::move(live).value();
  if (!options.small_static_scene.empty()) {
    const auto small = stage(options.small_static_scene, *motion);
    if (!small.ok()) return small.error();
    auto small_live = LiveStage::make(*small, *builder);
    if (!small_live.ok()) return small_live.error();
    show.small.stage = std::move(small_live).value();
  }
  if (staged->static_nodes > 0) {
    auto assembled = assemble(staged->only_static(), *builder);
    if (!assembled.ok()) return assembled.error();
    show.static_part.snapshot = std::move(assembled).value();
    Seen warm;
    scenegraph::TraceStats unused;
    const auto looked = look(*show.static_part.snapshot, *view, warm, unused);
    if (!looked.ok()) return looked.error();
  }
  auto peers = open_peers(options, *staged, *motion, *view, common.threads);
  if (!peers.ok()) return peers.error();
  show.peers = std::move(peers).value();
  return play_all(common, options, show);
}

}  // namespace sightline::bench
