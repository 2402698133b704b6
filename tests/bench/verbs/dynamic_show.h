// The parts of a moving show, what their frames have cost, and the rows that say so.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/bench/embree/mover.h"
#include "tests/bench/verbs/disagreement.h"
#include "tests/bench/verbs/frame_view.h"
#include "tests/bench/verbs/options.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// What a frame cost, in milliseconds.
struct Cost {
  double update = 0, build = 0, trace = 0;
  double all() const { return update + build + trace; }
};

/// A scene of ours, and what each of its frames cost.
struct Ours {
  std::unique_ptr<LiveStage> stage;
  std::vector<Cost> costs;
  std::vector<double> again;     ///< The same rays when all is grown.
  scenegraph::TraceStats stats;  ///< Of the last frame.
};

/// The same of Embree's.
struct Peer {
  std::string name;  ///< As a part of keys.
  std::unique_ptr<EmbreeMover> mover;
  std::vector<Cost> costs;
  std::vector<accel::geometry::Hit> hits, shadowed;
  Disagreement disagreement;
};

/// What stands still, alone.
struct Still {
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot;  ///< Null: nothing stands still.
  std::vector<double> trace;
};

/// All that takes turns within a frame.
struct Show {
  const Motion& motion;
  const StagedScene& staged;
  const FrameView& view;
  int threads;
  Ours ours, small;  ///< `small`: over the small static scene, if there is one.
  Still still;
  std::vector<Peer> peers;
};

/// What the newest frame of each has cost.
Row frame_row(const Show& show, std::size_t frame, const Seen& seen);

/// Medians over the frames after the first two, and quotients within frames.
Row last_row(const CommonOptions& common, const DynamicOptions& options, const Show& show,
             const std::vector<Row>& frames);

}  // namespace sightline::bench
