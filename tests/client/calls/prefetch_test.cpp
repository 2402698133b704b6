// Prefetch over a real connection.
#include "client/prefetch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::calls {
namespace {

using tests::DownwardRays;
using tests::kScene;

constexpr std::uint32_t kSheets = 7;

class Prefetch : public tests::LiveClient {
 protected:
  Prefetch() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(kSheets), {})); }

  std::uint64_t triangles_built() { return client_.scene_stats(kScene)->triangles_built; }
  std::uint64_t cells_of_cast(const DownwardRays& rays) {
    const auto report = client_.cast_stream(kScene, rays.columns(), {});
    EXPECT_TRUE(report);
    return report->cells_expanded;
  }
};

TEST_F(Prefetch, BuildsEverythingAndReportsIt) {
  std::optional<PrefetchReport> last;
  const auto built =
      client_.prefetch(kScene, {}, [&](const PrefetchReport& report) { last = report; });
  ASSERT_TRUE(built) << built.error().message;
  EXPECT_EQ(built->revision, 1U);
  EXPECT_EQ(built->meshes_done, 1U);
  EXPECT_EQ(built->meshes_total, 1U);
  EXPECT_EQ(built->triangles_done, 4U);
  EXPECT_EQ(built->triangles_total, 4U);
  EXPECT_GT(built->cells_expanded, 0U);
  EXPECT_GT(built->bytes_trees, 0U);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->triangles_done, 4U);
  EXPECT_EQ(last->cells_expanded, built->cells_expanded);
  EXPECT_EQ(triangles_built(), 4U);
  EXPECT_EQ(cells_of_cast(DownwardRays(100, kSheets)), 0U);
}

TEST_F(Prefetch, PointsBuildWhatTheyNeed) {
  const std::vector<double> positions{0.2, 0.2, 0.1, 0.7, 0.3, 0.1};
  const PointColumns<const double> points{positions};
  const auto built = client_.prefetch_points(kScene, points);
  ASSERT_TRUE(built) << built.error().message;
  EXPECT_EQ(built->rays_done, 2U);
  std::vector<double> distances(2);
  const auto report = client_.nearest(kScene, points, {.t = distances});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->cells_expanded, 0U);
  const std::vector<float> singles(positions.begin(), positions.end());
  EXPECT_EQ(client_.prefetch_points(kScene, PointColumns<const float>{singles})->cells_expanded,
            0U);
  const PointGrid grid{
      .origin = {0, 0, 0.1}, .across = {1, 0, 0}, .down = {0, 0.5, 0}, .columns = 7, .rows = 2};
  EXPECT_EQ(client_.prefetch_points(kScene, grid)->rays_done, 14U);
  EXPECT_EQ(client_.prefetch_points(kScene, points, {.roots = {99}}).error().code, Code::kNotFound);
}

TEST_F(Prefetch, RootsAndExclusionsOmitTrees) {
  EXPECT_EQ(client_.prefetch(kScene, {.roots = {2, 3}, .exclude = {1}})->meshes_total, 0U);
  EXPECT_EQ(triangles_built(), 0U);
  EXPECT_EQ(client_.prefetch(kScene, {.roots = {2, 3}, .exclude = {2}})->meshes_total, 1U);
  EXPECT_EQ(triangles_built(), 4U);
  const auto unknown = client_.prefetch(kScene, {.roots = {99}});
  EXPECT_EQ(unknown.error().code, Code::kNotFound);
  EXPECT_EQ(unknown.error().reason, "NODE_NOT_FOUND");
  EXPECT_EQ(client_.prefetch("projects/default/scenes/nowhere").error().code, Code::kNotFound);
}

TEST_F(Prefetch, RaysOfManyMessagesAreCounted) {
  const std::size_t n = 2 * kRaysPerMessage + 17;
  const DownwardRays rays(n, kSheets);
  std::vector<std::uint64_t> reported;
  const auto grown = client_.prefetch_rays(
      kScene, rays.columns(), {},
      [&](const PrefetchReport& report) { reported.push_back(report.rays_done); });
  ASSERT_TRUE(grown) << grown.error().message;
  EXPECT_EQ(grown->rays_done, n);
  EXPECT_GT(grown->cells_expanded, 0U);
  EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
  EXPECT_EQ(reported.back(), n);
  EXPECT_EQ(cells_of_cast(rays), 0U);
}

TEST_F(Prefetch, FloatsBuildTheSameCellsAsDoubles) {
  const DownwardRays rays(50, kSheets);
  const std::vector<float> origins(rays.origins.begin(), rays.origins.end());
  const std::vector<float> directions(rays.directions.begin(), rays.directions.end());
  const RayColumns<const float> floats{origins, directions};
  EXPECT_GT(client_.prefetch_rays(kScene, floats)->cells_expanded, 0U);
  EXPECT_EQ(client_.prefetch_rays(kScene, rays.columns())->cells_expanded, 0U);
}

TEST_F(Prefetch, AnEmptyBatchIsACall) {
  EXPECT_EQ(client_.prefetch_rays(kScene, RayColumns<const double>{})->rays_done, 0U);
  EXPECT_EQ(triangles_built(), 0U);
  EXPECT_EQ(client_.prefetch_rays("projects/default/scenes/nowhere", RayColumns<const double>{})
                .error()
                .code,
            Code::kNotFound);
}

TEST_F(Prefetch, ASourceThatFailsEndsIt) {
  const RaySource<double> source = [](const RayColumns<double>&) -> Result<std::size_t> {
    return Error{Code::kDataLoss, "bad disk", {}};
  };
  EXPECT_EQ(client_.prefetch_rays(kScene, source, {}).error().message, "bad disk");
}

TEST_F(Prefetch, ColumnsOfDifferentLengthsAreNotSent) {
  DownwardRays rays(3, kSheets);
  rays.directions.pop_back();
  EXPECT_EQ(client_.prefetch_rays(kScene, rays.columns()).error().code, Code::kInvalidArgument);
}

TEST_F(Prefetch, AStopCancelsIt) {
  std::stop_source stop;
  stop.request_stop();
  const auto built = client_.prefetch(kScene, {.stop = stop.get_token()});
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().code, Code::kCancelled);
  const DownwardRays rays(5, kSheets);
  EXPECT_EQ(client_.prefetch_rays(kScene, rays.columns(), {.stop = stop.get_token()}).error().code,
            Code::kCancelled);
  EXPECT_TRUE(client_.prefetch(kScene));
}

}  // namespace
}  // namespace sightline::client::calls
