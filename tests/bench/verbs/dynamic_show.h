// The parts of a dynamic measurement, the costs of their frames, and their rows.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/bench/embree/dynamic_peer.h"
#include "tests/bench/verbs/disagreement.h"
#include "tests/bench/verbs/frame_view.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// The cost of a frame, in milliseconds.
struct Cost {
  double update = 0, build = 0, trace = 0;
  double all() const { return update + build + trace; }
};

/// One of our scenes, and the cost of each of its frames.
struct Ours {
  std::unique_ptr<LiveStage> stage;
  std::vector<Cost> costs;
  std::vector<double> again;     ///< Tracing the same rays again, when all cells are grown.
  scenegraph::TraceStats stats;  ///< Of the last frame.
};

/// The same for Embree.
struct Peer {
  std::string name;  ///< Used in keys.
  std::unique_ptr<EmbreeDynamicPeer> embree;
  std::vector<Cost> costs;
  std::vector<accel::geometry::Hit> hits, shadowed;
  Disagreement disagreement;
};

/// The static part alone.
struct StaticPart {
  std::shared_ptr<const scenegraph::revision::Snapshot>
      snapshot;  ///< Null: there is no static part.
  std::vector<double> trace;
};

/// Everything that takes turns within a frame.
struct Show {
  const Motion& motion;
  const StagedScene& staged;
  const FrameView& view;
  int threads;
  Ours ours, small;  ///< `small`: over the small static scene, if there is one.
  StaticPart static_part;
  std::vector<Peer> peers;
};

/// The row of the newest frame.
Row frame_row(const Show& show, std::size_t frame, const Seen& seen);

/// The last row: medians over the frames after the first two, and quotients within frames.
Row last_row(const CommonOptions& common, const DynamicOptions& options, const Show& show,
             const std::vector<Row>& frames);

}  // namespace sightline::bench
