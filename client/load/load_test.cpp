// Prepares the rays of each coverage, and takes the builds in turn.
#include "client/load/load_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "client/load/cast_target.h"
#include "client/load/moving_copy.h"

namespace sightline::client::load {
namespace {

std::array<double, 3> normal_at(const std::vector<float>& normals, std::size_t i) {
  std::array<double, 3> normal{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    normal[axis] = static_cast<double>(normals[3 * i + axis]);
  return normal;
}

constexpr std::size_t kWarmRays = std::size_t{1} << 20;

class LoadTest {
 public:
  LoadTest(const LoadOptions& options, std::stop_token stop, const LoadProgress& progress)
      : options_(options), stop_(std::move(stop)), progress_(progress) {}

  Result<LoadResult> run(const Connect& connect) {
    if (const Status ready = prepare(connect); !ready) return ready.error();
    const bool is_cold = !options_.compare.empty();
    const std::vector<BuildMode> builds =
        is_cold ? options_.compare : std::vector{BuildMode::kServerPolicy};
    for (const double coverage : options_.coverage) {
      const auto rays = make_rays(coverage / 100);
      if (!rays) return rays.error();
      if (is_stopped()) break;
      if (const Status ran = run_builds(builds, coverage, *rays, is_cold); !ran) return ran.error();
    }
    result_.interrupted = is_stopped();
    return std::move(result_);
  }

 private:
  bool is_stopped() const { return stop_.stop_requested(); }
  const Client& client() const { return clients_.front(); }
  std::size_t workers() const { return options_.rate ? kMostInFlight : options_.clients; }

  Status prepare(const Connect& connect) {
    const std::size_t connections = options_.rate ? kOpenLoopConnections : options_.clients;
    for (std::size_t i = 0; i < connections; ++i) {
      auto client = connect();
      if (!client) return client.error();
      clients_.push_back(*std::move(client));
    }
    auto scene = client().get_scene(options_.scene);
    if (!scene) return scene.error();
    result_.scene = *std::move(scene);
    auto server = client().server_info();
    if (!server) return server.error();
    result_.server = *std::move(server);
    const auto stats = client().scene_stats(options_.scene);
    if (!stats) return stats.error();
    result_.triangles_total = stats->triangles_total;
    return {};
  }

  Caster caster() const {
    return [this](std::span<const Ray> rays) -> Result<std::vector<Found>> {
      std::vector<double> t(rays.size());
      std::vector<float> normal(3 * rays.size());
      const RaySet sent = RaySet::of(rays, RaySet::Precision::kDouble);
      const auto report = sent.with(0, sent.size(), [&](const auto& columns) {
        return client().cast_stream(options_.scene, columns, {.t = t, .normal = normal},
                                    {.build = BuildMode::kLazy, .stop = stop_});
      });
      if (!report) return report.error();
      std::vector<Found> found(rays.size());
      for (std::size_t i = 0; i < found.size(); ++i) found[i] = {t[i], normal_at(normal, i)};
      return found;
    };
  }

  Result<RaySet> make_rays(double coverage) {
    if (const RaySet* const file = std::get_if<RaySet>(&options_.rays)) {
      if (coverage >= 1) return *file;
      return part_of(*file, coverage, result_.scene, caster(), options_.seed);
    }
    if (!maker_) {
      auto maker =
          RayMaker::make(std::get<RayKind>(options_.rays), result_.scene, caster(), options_.seed);
      if (!maker) return maker.error();
      maker_ = *std::move(maker);
    }
    const std::size_t wanted =
        options_.compare.empty() ? kWarmRays : static_cast<std::size_t>(options_.rays_per_run);
    return maker_->rays(coverage, std::min(wanted, kMostRays));
  }

  /// The builds take turns, so that what else happens on the machine meets all of them.
  Status run_builds(const std::vector<BuildMode>& builds, double coverage, const RaySet& rays,
                    bool is_cold) {
    std::vector<std::vector<Row>> done(builds.size());
    const int rounds = is_cold ? options_.repeat : 1;
    for (int round = 0; round < rounds; ++round) {
      for (std::size_t k = 0; k < builds.size() && !is_stopped(); ++k) {
        // A run that is cut short would be again.
        if (!done[k].empty() && !done[k].back().run.complete) continue;
        if (is_cold) {
          const auto cooled = client().cool_scene(options_.scene);
          if (!cooled) return cooled.error();
        }
        Row row;
        row.build = builds[k];
        row.coverage = coverage;
        row.cold = is_cold;
        if (const Status ran = run_once(rays, row); !ran) return ran.error();
        done[k].push_back(std::move(row));
      }
    }
    for (std::vector<Row>& rows : done) {
      if (rows.empty()) continue;
      const auto middle = rows.begin() + static_cast<std::ptrdiff_t>((rows.size() - 1) / 2);
      std::nth_element(rows.begin(), middle, rows.end(),
                       [](const Row& a, const Row& b) { return duration_s(a) < duration_s(b); });
      middle->runs = static_cast<int>(rows.size());
      warn(*middle);
      result_.rows.push_back(std::move(*middle));
    }
    return {};
  }

  RunOptions run_options(bool is_cold) const {
    RunOptions run{.schedule = options_.rate ? Schedule::open(*options_.rate) : Schedule::closed(),
                   .workers = workers()};
    const double seconds = options_.seconds.value_or(is_cold ? kMostColdSeconds : kMostSeconds);
    run.most = from_seconds(seconds);
    if (is_cold) {
      run.requests = (options_.rays_per_run + options_.batch - 1) / options_.batch;
      run.window = from_seconds(0.1);
      run.drain = {};
      run.is_strict = false;
      return run;
    }
    constexpr double kFewestWindows = 5;
    run.until_stable = !options_.seconds;
    run.window = from_seconds(std::min(1.0, seconds / kFewestWindows));
    run.warm_up = run.window;
    return run;
  }

  Status run_once(const RaySet& rays, Row& row) {
    std::optional<MovingCopy> copy;
    if (options_.updates > 0) {
      auto added = MovingCopy::add(client(), options_.scene);
      if (!added) return added.error();
      copy.emplace(*std::move(added));
    }
    CastTarget target(clients_, rays, copy ? &*copy : nullptr, workers(),
                      {.scene = options_.scene,
                       .cast = {.kind = options_.kind, .build = row.build},
                       .batch = options_.batch,
                       .updates = options_.updates});
    const RunOptions run = run_options(row.cold);
    const std::string label =
        row.cold ? fmt::format("{} {} %", name_of(row.build), row.coverage) : "load";
    constexpr double kInterval = 0.02, kWarmInterval = 0.25;
    const ProcessorMeter meter;
    GrowthSampler growth([this] { return client().scene_stats(options_.scene); }, clock_,
                         from_seconds(row.cold ? kInterval : kWarmInterval));
    row.run = load::run(run, target, clock_, stop_, [&](Nanoseconds elapsed, std::uint64_t cast) {
      if (!progress_) return;
      const double by_time =
          elapsed / std::chrono::duration<double, std::nano>(run.warm_up + run.most);
      const double by_rays =
          row.cold ? static_cast<double>(cast) / static_cast<double>(options_.rays_per_run) : 0;
      progress_(label, std::clamp(std::max(by_time, by_rays), 0.0, 1.0), cast);
    });
    row.use = meter.use();
    row.growth = growth.finish();
    return {};
  }

  void warn(const Row& row) {
    const Record& record = row.run.record;
    const std::string name =
        row.cold ? fmt::format("{} at {} %: ", name_of(row.build), row.coverage) : "";
    const std::string slow = bottleneck(row.use, seconds_of(record.in_flight));
    if (!slow.empty())
      result_.warnings.push_back(fmt::format(
          "{}{}: it is itself a bottleneck, and the server may do more than is shown", name, slow));
    if (record.failed + record.refused + record.updates_failed > 0) {
      result_.warnings.push_back(fmt::format("{}{} requests failed, {} were refused: {}", name,
                                             record.failed + record.updates_failed, record.refused,
                                             record.first_error));
    }
    if (!row.cold && !options_.seconds && !row.run.stable && !is_stopped())
      result_.warnings.push_back(
          fmt::format("{}not stable after {} s: latencies went on to change", name, kMostSeconds));
    if (row.cold && !row.run.complete && !is_stopped()) {
      result_.warnings.push_back(
          fmt::format("{}only {} of {} rays were answered in {:g} s{}", name, record.rays,
                      options_.rays_per_run, options_.seconds.value_or(kMostColdSeconds),
                      record.rays == 0 ? "; smaller requests have answers sooner" : ""));
    }
  }

  static constexpr std::size_t kMostRays = std::size_t{1} << 23;

  const LoadOptions& options_;
  const std::stop_token stop_;
  const LoadProgress& progress_;
  SteadyClock clock_;
  std::vector<Client> clients_;
  std::optional<RayMaker> maker_;
  LoadResult result_;
};

}  // namespace

Result<LoadResult> run_load(const LoadOptions& options, const Connect& connect,
                            const std::stop_token& stop, const LoadProgress& progress) {
  return LoadTest(options, stop, progress).run(connect);
}

}  // namespace sightline::client::load
