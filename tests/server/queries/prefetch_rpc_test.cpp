// Prefetch through a real server.
#include "server/queries/prefetch_rpc.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <chrono>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "server/queries/prefetch_job.h"
#include "server/queries/ray_codec.h"
#include "tests/server/queries/points_rpc.h"
#include "tests/server/support/live_server.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

constexpr std::uint32_t kLarge = 512;  // planar_sheet of half a million triangles

v1::PrefetchRequest prefetch_of(const std::string& scene) {
  v1::PrefetchRequest request;
  request.set_scene(scene);
  return request;
}

v1::CastRaysRequest all_fields(std::span<const accel::geometry::Ray> rays, v1::BuildMode build) {
  v1::CastRaysRequest request = cast_request(kScene, rays);
  request.set_build(build);
  for (const auto field : {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE,
                           v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT})
    request.add_fields(field);
  return request;
}

scenegraph::model::Affine moved(double x) {
  scenegraph::model::Affine affine;
  affine.m[3] = x;
  return affine;
}

/// Every count of `after` is at least that of `before`, and none exceeds its total.
void expect_grown(const v1::PrefetchResponse& before, const v1::PrefetchResponse& after) {
  EXPECT_GE(after.meshes_done(), before.meshes_done());
  EXPECT_GE(after.triangles_done(), before.triangles_done());
  EXPECT_GE(after.rays_done(), before.rays_done());
  EXPECT_GE(after.cells_expanded(), before.cells_expanded());
  EXPECT_GE(after.build_us(), before.build_us());
  EXPECT_GE(after.elapsed_us(), before.elapsed_us());
  EXPECT_LE(after.meshes_done(), after.meshes_total());
  EXPECT_LE(after.triangles_done(), after.triangles_total());
  EXPECT_LE(after.rays_done(), after.rays_total());
}

class PrefetchRpcTest : public PointsRpc {
 protected:
  using PointsRpc::PointsRpc;
  /// Reads to the end. `last` receives the last report.
  grpc::Status prefetch(const v1::PrefetchRequest& request, v1::PrefetchResponse* last = nullptr) {
    grpc::ClientContext context;
    const auto reader = api_.rays->Prefetch(&context, request);
    v1::PrefetchResponse before, now;
    bool done = false;
    while (reader->Read(&now)) {
      EXPECT_FALSE(done) << "no report follows the last one";
      expect_grown(before, now);
      done = now.done();
      before = now;
    }
    const grpc::Status status = reader->Finish();
    EXPECT_EQ(done, status.ok());
    if (last != nullptr) *last = before;
    return status;
  }

  v1::PrefetchResponse prefetched(const v1::PrefetchRequest& request) {
    v1::PrefetchResponse last;
    const grpc::Status status = prefetch(request, &last);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return last;
  }

  std::uint64_t cells_of_cast(const v1::CastRaysRequest& request) {
    return api_.cast(request).stats().cells_expanded();
  }

  /// The hits, not checked, and as bytes.
  v1::CastRaysResponse cast(std::span<const accel::geometry::Ray> rays, v1::BuildMode build) {
    return api_.cast(all_fields(rays, build));
  }
  std::string bytes_of(std::span<const accel::geometry::Ray> rays, v1::BuildMode build) {
    const v1::CastRaysResponse reply = cast(rays, build);
    std::string bytes;
    for (const v1::HitColumn& column : reply.columns()) bytes += column.data();
    return bytes;
  }

  /// Roots 1 and 3, each with a cube below (2, 4), and a separate soup (5) under node 3.
  void make_two_groups() {
    ASSERT_TRUE(api_.create(kScene).ok());
    const std::string shared = api_.add_mesh(cube());
    const std::string own = api_.add_mesh(random_soup(500, 0.1, 7));
    v1::ApplyUpdatesResponse reply;
    ASSERT_TRUE(api_.apply(kScene,
                           {put_node(-1), put_node(-2, shared, -1), put_node(-3),
                            put_node(-4, shared, -3, moved(5)), put_node(-5, own, -3, moved(9))},
                           &reply)
                    .ok());
    ASSERT_EQ(reply.nodes(4), 5u);
  }
};

TEST_F(PrefetchRpcTest, BuildsTheWholeScene) {
  const TestMesh mesh = random_soup(3000, 0.05, 5);
  api_.make_scene(kScene, mesh);
  const v1::PrefetchResponse last = prefetched(prefetch_of(kScene));
  EXPECT_EQ(last.served().revision(), 1u);
  EXPECT_EQ(last.meshes_done(), 1u);
  EXPECT_EQ(last.meshes_total(), 1u);
  EXPECT_EQ(last.triangles_done(), 3000u);
  EXPECT_EQ(last.triangles_total(), 3000u);
  EXPECT_GT(last.cells_expanded(), 0u);
  EXPECT_EQ(last.rays_total(), 0u);
  const v1::GetSceneStatsResponse stats = api_.stats(kScene);
  EXPECT_EQ(stats.triangles_built(), 3000u);
  EXPECT_EQ(stats.cells_deferred(), 0u);
  EXPECT_EQ(stats.instances_entered(), 1u);
  EXPECT_EQ(stats.bytes_trees(), last.bytes_trees());
  EXPECT_EQ(cells_of_cast(cast_request(kScene, rays_at(mesh, 500, 1))), 0u);
  EXPECT_EQ(prefetched(prefetch_of(kScene)).cells_expanded(), 0u) << "it may be repeated";
}

TEST_F(PrefetchRpcTest, HitsEqualThoseOfOtherBuildModes) {
  const TestMesh mesh = random_soup(2000, 0.2, 11);
  const std::vector<accel::geometry::Ray> rays = rays_at(mesh, 400, 3);
  api_.make_scene(kScene, mesh);
  const std::string expected = bytes_of(rays, v1::BUILD_MODE_NONE);
  const BruteForce oracle({PlacedMesh{mesh.view()}});
  const auto judged =
      compare(rays, decode_hits(cast(rays, v1::BUILD_MODE_NONE)), oracle, {.surface = true});
  EXPECT_TRUE(judged.clean()) << judged.report();
  EXPECT_GT(judged.hits, 100u);
  v1::PrefetchRequest some = prefetch_of(kScene);
  *some.mutable_rays() = encode_rays(std::span(rays).first(50));
  prefetched(some);
  EXPECT_EQ(bytes_of(rays, v1::BUILD_MODE_NONE), expected);
  EXPECT_EQ(bytes_of(rays, v1::BUILD_MODE_LAZY), expected);
  prefetched(prefetch_of(kScene));
  EXPECT_EQ(bytes_of(rays, v1::BUILD_MODE_LAZY), expected);
  EXPECT_EQ(bytes_of(rays, v1::BUILD_MODE_FULL), expected);
}

TEST_F(PrefetchRpcTest, BuildsOnlyUnderTheRootsWithoutExclusions) {
  make_two_groups();
  v1::PrefetchRequest request = prefetch_of(kScene);
  request.add_roots(1);
  request.add_roots(3);
  request.add_exclude(5);
  const v1::PrefetchResponse cubes = prefetched(request);
  EXPECT_EQ(cubes.meshes_total(), 1u) << "two instances of one mesh";
  EXPECT_EQ(cubes.triangles_done(), 12u);
  EXPECT_EQ(api_.stats(kScene).triangles_built(), 12u);
  EXPECT_EQ(api_.stats(kScene).instances_entered(), 2u);
  request.clear_exclude();
  EXPECT_EQ(prefetched(request).triangles_done(), 512u);
  EXPECT_EQ(api_.stats(kScene).triangles_built(), 512u);
  request.add_exclude(1);
  request.add_exclude(3);
  EXPECT_EQ(prefetched(request).meshes_total(), 0u);
}

TEST_F(PrefetchRpcTest, BuildsOnlyWhatLabelsSelect) {
  make_two_groups();
  v1::Update group = put_node(3);
  group.mutable_put_node()->add_labels()->set_key("class");
  ASSERT_TRUE(api_.apply(kScene, {group}).ok());
  v1::PrefetchRequest request = prefetch_of(kScene);
  request.add_exclude_labels()->set_key("class");
  EXPECT_EQ(prefetched(request).triangles_done(), 12u);
  *request.mutable_only_labels() = request.exclude_labels();
  EXPECT_EQ(prefetched(request).meshes_total(), 0u);
  request.clear_exclude_labels();
  EXPECT_EQ(prefetched(request).triangles_done(), 512u);
}

TEST_F(PrefetchRpcTest, BuildsOnlyTheCellsThatRaysEnter) {
  api_.make_scene(kScene, planar_sheet(64));
  const std::vector<accel::geometry::Ray> rays = rays_downward(300);
  v1::PrefetchRequest request = prefetch_of(kScene);
  *request.mutable_rays() = encode_rays(rays);
  const v1::PrefetchResponse last = prefetched(request);
  EXPECT_EQ(last.rays_done(), 300u);
  EXPECT_EQ(last.rays_total(), 300u);
  EXPECT_EQ(last.meshes_total(), 0u);
  EXPECT_GT(last.cells_expanded(), 0u);
  const v1::GetSceneStatsResponse stats = api_.stats(kScene);
  EXPECT_GT(stats.triangles_built(), 0u);
  EXPECT_LT(stats.triangles_built(), stats.triangles_total() / 4) << "the rays meet one corner";
  EXPECT_EQ(last.bytes_trees(), 0u);
  EXPECT_EQ(cells_of_cast(cast_request(kScene, rays)), 0u);
}

TEST_F(PrefetchRpcTest, BuildsWhatQueriesOfPointsNeed) {
  api_.make_scene(kScene, planar_sheet(64));
  std::vector<double> positions;
  for (int i = 0; i < 20; ++i) positions.insert(positions.end(), {0.01 * i, 0.01 * i, 0.02});
  const v1::QueryPointsRequest query = points_request(positions);
  v1::PrefetchRequest request = prefetch_of(kScene);
  *request.mutable_points() = query.points();
  const v1::PrefetchResponse last = prefetched(request);
  EXPECT_EQ(last.rays_done(), 20u);
  EXPECT_EQ(last.rays_total(), 20u);
  EXPECT_GT(last.cells_expanded(), 0u);
  const v1::GetSceneStatsResponse stats = api_.stats(kScene);
  EXPECT_GT(stats.triangles_built(), 0u);
  EXPECT_LT(stats.triangles_built(), stats.triangles_total() / 4) << "the points are at one corner";
  EXPECT_EQ(answer(query).stats().cells_expanded(), 0u);
}

TEST_F(PrefetchRpcTest, BuildsWhatAGridOfPointsNeeds) {
  api_.make_scene(kScene, planar_sheet(64));
  v1::QueryPointsRequest query = points_request({});
  v1::PointGrid& grid = *query.mutable_grid();
  for (const double x : {0.0, 0.0, 0.1}) grid.add_origin(x);
  for (const double x : {0.02, 0.0, 0.0}) grid.add_across(x);
  for (const double x : {0.0, 0.02, 0.0}) grid.add_down(x);
  grid.set_columns(5);
  grid.set_rows(4);
  v1::PrefetchRequest request = prefetch_of(kScene);
  *request.mutable_grid() = grid;
  EXPECT_EQ(prefetched(request).rays_done(), 20u);
  EXPECT_EQ(answer(query).stats().cells_expanded(), 0u);
  request.mutable_grid()->set_columns(0);
  EXPECT_EQ(prefetch(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(PrefetchRpcTest, TheKindDecidesHowFarRaysGo) {
  api_.make_scene(kScene, flat_walls(2000));
  std::vector<accel::geometry::Ray> rays(1);
  rays[0].origin = {-0.5, 0.3, 0.4};
  rays[0].direction = {1, 0, 0};
  const auto built = [&](v1::QueryKind kind) {
    v1::PrefetchRequest request = prefetch_of(kScene);
    *request.mutable_rays() = encode_rays(rays);
    request.set_kind(kind);
    prefetched(request);
    return api_.stats(kScene).triangles_built();
  };
  EXPECT_LT(built(v1::QUERY_KIND_ANY), 4000u);
  EXPECT_LT(built(v1::QUERY_KIND_CLOSEST), 4000u);
  EXPECT_EQ(built(v1::QUERY_KIND_COUNT), 4000u);
}

TEST_F(PrefetchRpcTest, RaysSeeOnlyTheirRoot) {
  make_two_groups();
  std::vector<accel::geometry::Ray> rays(1);
  rays[0].origin = {-5, 0.3, 0.4};
  rays[0].direction = {1, 0, 0};
  v1::PrefetchRequest request = prefetch_of(kScene);
  *request.mutable_rays() = encode_rays(rays);
  request.add_roots(1);
  request.add_exclude(2);
  prefetched(request);
  EXPECT_EQ(api_.stats(kScene).instances_entered(), 0u);
  request.clear_exclude();
  prefetched(request);
  EXPECT_EQ(api_.stats(kScene).instances_entered(), 1u);
}

TEST_F(PrefetchRpcTest, RefusesUnknownValues) {
  make_two_groups();
  EXPECT_EQ(prefetch(prefetch_of("nonsense")).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(prefetch(prefetch_of("projects/p/scenes/none")).error_code(),
            grpc::StatusCode::NOT_FOUND);
  v1::PrefetchRequest request = prefetch_of(kScene);
  request.add_roots(1);
  request.add_roots(77);
  EXPECT_EQ(reason_of(prefetch(request)), "NODE_NOT_FOUND");
  EXPECT_NE(prefetch(request).error_message().find("root node 77"), std::string::npos);
  *request.mutable_rays() = encode_rays(rays_downward(1));
  EXPECT_EQ(reason_of(prefetch(request)), "TOO_MANY_ROOTS");
  request.mutable_roots()->RemoveLast();
  request.add_exclude(78);
  EXPECT_NE(prefetch(request).error_message().find("excluded node 78"), std::string::npos);
  request.clear_exclude();
  *request.mutable_rays() = encode_rays(rays_downward(server::queries::kMaxRaysPerRequest + 1));
  EXPECT_EQ(reason_of(prefetch(request)), "TOO_MANY_RAYS");
  request = prefetch_of(kScene);
  request.set_kind(static_cast<v1::QueryKind>(99));
  EXPECT_EQ(reason_of(prefetch(request)), "UNKNOWN_KIND");
  request = prefetch_of(kScene);
  for (int i = 0; i <= server::queries::kMaxPrefetchRoots; ++i) request.add_roots(1);
  EXPECT_EQ(reason_of(prefetch(request)), "TOO_MANY_ROOTS");
}

TEST_F(PrefetchRpcTest, AnEmptySceneFinishesAtOnce) {
  ASSERT_TRUE(api_.create(kScene).ok());
  EXPECT_EQ(prefetched(prefetch_of(kScene)).meshes_total(), 0u);
  v1::PrefetchRequest request = prefetch_of(kScene);
  request.mutable_rays();
  EXPECT_EQ(prefetched(request).rays_total(), 0u);
}

TEST_F(PrefetchRpcTest, ACancelledCallLeavesAUsableSceneAndFreesItsSlot) {
  const TestMesh mesh = planar_sheet(kLarge);
  api_.make_scene(kScene, mesh);
  for (int round = 0; round < 12; ++round) {
    grpc::ClientContext context;
    const auto reader = api_.rays->Prefetch(&context, prefetch_of(kScene));
    v1::PrefetchResponse report;
    if (round % 2 == 1) reader->Read(&report);  // The first report, or the last
    context.TryCancel();
    while (reader->Read(&report)) {
    }
    reader->Finish();
    v1::CastRaysResponse reply;
    ASSERT_TRUE(api_.cast(cast_request(kScene, rays_downward(100)), &reply).ok());
    EXPECT_EQ(reply.stats().hits(), 100u);
  }
  // The server may still be ending the last one.
  v1::PrefetchResponse last;
  grpc::Status status = prefetch(prefetch_of(kScene), &last);
  while (status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED)
    status = prefetch(prefetch_of(kScene), &last);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(last.triangles_done(), last.triangles_total());
  EXPECT_EQ(api_.stats(kScene).triangles_built(), mesh.faces.size());
}

TEST_F(PrefetchRpcTest, ADeadlineEndsIt) {
  api_.make_scene(kScene, planar_sheet(kLarge));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() - std::chrono::seconds(1));
  const auto reader = api_.rays->Prefetch(&context, prefetch_of(kScene));
  v1::PrefetchResponse report;
  EXPECT_FALSE(reader->Read(&report));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  prefetched(prefetch_of(kScene));
}

TEST_F(PrefetchRpcTest, QueriesAndPrefetchesOfOneSceneRunConcurrently) {
  const TestMesh mesh = random_soup(200'000, 0.01, 9);
  api_.make_scene(kScene, mesh);
  const std::vector<accel::geometry::Ray> rays = rays_at(mesh, 200, 1);
  const std::string expected = bytes_of(rays, v1::BUILD_MODE_NONE);
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&] { prefetched(prefetch_of(kScene)); });
    threads.emplace_back([&] { EXPECT_EQ(bytes_of(rays, v1::BUILD_MODE_LAZY), expected); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(api_.stats(kScene).cells_deferred(), 0u);
}

server::ServerConfig config_of_no_prefetches() {
  server::ServerConfig config = test_config();
  config.max_prefetches = 0;
  return config;
}

class NoPrefetchesTest : public PrefetchRpcTest {
 protected:
  NoPrefetchesTest() : PrefetchRpcTest(config_of_no_prefetches()) {}
};

TEST_F(NoPrefetchesTest, IsRefusedWithTheLimit) {
  api_.make_scene(kScene, cube());
  const grpc::Status status = prefetch(prefetch_of(kScene));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(reason_of(status), "TOO_MANY_PREFETCHES");
  EXPECT_NE(status.error_message().find("the limit is 0"), std::string::npos);
  EXPECT_EQ(api_.stats(kScene).cells_expanded(), 0u);
}

server::ServerConfig config_of_few_rays() {
  server::ServerConfig config = test_config();
  config.admission.rays = 100;
  return config;
}

class PrefetchOfFewRaysTest : public PrefetchRpcTest {
 protected:
  PrefetchOfFewRaysTest() : PrefetchRpcTest(config_of_few_rays()) {}
};

TEST_F(PrefetchOfFewRaysTest, RaysCountInTheQueue) {
  api_.make_scene(kScene, cube());
  v1::PrefetchRequest request = prefetch_of(kScene);
  *request.mutable_rays() = encode_rays(rays_downward(101));
  EXPECT_EQ(reason_of(prefetch(request)), "QUEUE_FULL");
  *request.mutable_rays() = encode_rays(rays_downward(100));
  prefetched(request);
  prefetched(request);
}

}  // namespace
}  // namespace sightline::tests
