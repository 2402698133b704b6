// The rows of dynamic.
#include "tests/bench/verbs/dynamic_show.h"

#include <algorithm>

namespace sightline::bench {
namespace {

constexpr std::size_t kWarmUp = 2;  // Frames that the last row leaves out

// Medians over the frames after the first.
class Medians {
 public:
  explicit Medians(std::size_t frames) : first_(std::min(kWarmUp, frames - 1)), frames_(frames) {}

  template <class Value>
  double of(const Value& value) const {
    return median(all(value));
  }
  /// Also sets the quartiles.
  template <class Value>
  void set(Row& row, const std::string& key, const Value& value) const {
    row[key] = of(value);
    row[key + "_q1"] = quantile(all(value), 0.25);
    row[key + "_q3"] = quantile(all(value), 0.75);
  }

 private:
  template <class Value>
  std::vector<double> all(const Value& value) const {
    std::vector<double> values;
    for (std::size_t f = first_; f < frames_; ++f) values.push_back(value(f));
    return values;
  }
  std::size_t first_, frames_;
};

void set_costs(Row& row, const Medians& medians, const std::string& prefix,
               const std::vector<Cost>& costs) {
  row[prefix + "fps"] = 1e3 / medians.of([&](std::size_t f) { return costs[f].all(); });
  row[prefix + "update_ms"] = medians.of([&](std::size_t f) { return costs[f].update; });
  row[prefix + "build_ms"] = medians.of([&](std::size_t f) { return costs[f].build; });
  row[prefix + "trace_ms"] = medians.of([&](std::size_t f) { return costs[f].trace; });
}

}  // namespace

Row frame_row(const Show& show, std::size_t frame, const Seen& seen) {
  Row row;
  row["frame"] = frame;
  const auto set = [&](const std::string& prefix, const Cost& cost) {
    row[prefix + "update_ms"] = cost.update;
    row[prefix + "build_ms"] = cost.build;
    row[prefix + "trace_ms"] = cost.trace;
  };
  set("", show.ours.costs.back());
  row["again_ms"] = show.ours.again.back();
  if (show.static_part.snapshot) row["static_trace_ms"] = show.static_part.trace.back();
  const scenegraph::TraceStats& stats = show.ours.stats;
  row["static_touches"] = stats.touches + stats.touches_prepare - stats.dynamic_touches;
  row["dynamic_touches"] = stats.dynamic_touches;
  row["touches_prepare"] = stats.touches_prepare;
  row["cells_expanded"] = stats.cells_expanded;
  row["hits"] = stats.hits;
  row["hit_hash"] = seen.hash();
  if (show.small.stage) set("small_", show.small.costs.back());
  for (const Peer& peer : show.peers) set(peer.name + "_", peer.costs.back());
  return row;
}

Row last_row(const CommonOptions& common, const DynamicOptions& options, const Show& show,
             const std::vector<Row>& frames) {
  const std::vector<Cost>& costs = show.ours.costs;
  const Medians medians(costs.size());
  Row row;
  row["frames"] = options.frames;
  row["copies"] = options.copies;
  row["static"] = options.static_scene;
  row["rays"] = options.rays.kind;
  row["count"] = show.view.rays.size();
  row["shadow"] = options.shadow;
  row["view"] = options.view;
  row["threads"] = common.threads;
  row["triangles_moving"] = show.motion.triangles();
  row["triangles_static"] = show.staged.static_triangles;
  set_costs(row, medians, "", costs);
  row["again_ms"] = medians.of([&](std::size_t f) { return show.ours.again[f]; });
  std::uint64_t touches = 0;
  for (std::size_t f = std::min(kWarmUp, frames.size()); f < frames.size(); ++f)
    touches += frames[f]["static_touches"].get<std::uint64_t>();
  row["static_touches"] = touches;
  row["dynamic_touches"] =
      medians.of([&](std::size_t f) { return frames[f]["dynamic_touches"].get<double>(); });
  if (show.static_part.snapshot) {
    const auto& static_trace = show.static_part.trace;
    row["static_trace_ms"] = medians.of([&](std::size_t f) { return static_trace[f]; });
    medians.set(row, "trace_over_static",
                [&](std::size_t f) { return costs[f].trace / static_trace[f]; });
    row["again_over_static"] =
        medians.of([&](std::size_t f) { return show.ours.again[f] / static_trace[f]; });
  }
  if (show.small.stage) {
    const std::vector<Cost>& small = show.small.costs;
    row["static_small"] = options.small_static_scene;
    set_costs(row, medians, "small_", small);
    medians.set(row, "update_build_over_small", [&](std::size_t f) {
      return (costs[f].update + costs[f].build) / (small[f].update + small[f].build);
    });
  }
  for (const Peer& peer : show.peers) {
    set_costs(row, medians, peer.name + "_", peer.costs);
    medians.set(row, "over_" + peer.name,
                [&](std::size_t f) { return costs[f].all() / peer.costs[f].all(); });
    row[peer.name + "_layout"] = peer.embree->layout();
    row[peer.name + "_entry"] = peer.embree->entry(false);
    row[peer.name + "_differences"] = peer.disagreement.differences;
    row[peer.name + "_unexplained"] = peer.disagreement.unexplained;
  }
  return row;
}

}  // namespace sightline::bench
