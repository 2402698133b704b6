// CastRays through a real server.
#include "server/queries/cast_rpc.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "server/queries/cast_job.h"
#include "server/queries/ray_codec.h"
#include "tests/server/queries/random_rays.h"
#include "tests/server/support/live_server.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

void ask_for_all(v1::CastRaysRequest& request) {
  for (const auto field :
       {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_BARYCENTRIC,
        v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT, v1::HIT_FIELD_WORK}) {
    request.add_fields(field);
  }
}

class CastRpcTest : public LiveServer {
 protected:
  using LiveServer::LiveServer;

  grpc::Status fail(const v1::CastRaysRequest& request) {
    v1::CastRaysResponse reply;
    return api_.cast(request, &reply);
  }
};

TEST_F(CastRpcTest, HitsEqualTheOracles) {
  const TestMesh soup = random_soup(2000, 0.1, 11);
  api_.make_scene(kScene, soup);
  const BruteForce oracle({PlacedMesh{soup.view()}});
  const auto rays = random_rays(5000, 3);
  for (const auto build : {v1::BUILD_MODE_NONE, v1::BUILD_MODE_LAZY, v1::BUILD_MODE_FULL}) {
    v1::CastRaysRequest request = cast_request(kScene, rays);
    request.set_build(build);
    ask_for_all(request);
    const v1::CastRaysResponse reply = api_.cast(request);
    EXPECT_EQ(reply.served().revision(), 1u);
    const Comparison compared = compare(rays, decode_hits(reply), oracle, {.surface = true});
    EXPECT_TRUE(compared.clean()) << compared.report();
    EXPECT_GT(compared.hits, 100u);
    EXPECT_EQ(reply.stats().rays(), 5000u);
    EXPECT_EQ(reply.stats().hits(), compared.hits);
  }
}

TEST_F(CastRpcTest, AnyAgreesWithClosest) {
  api_.make_scene(kScene, random_soup(2000, 0.1, 11));
  v1::CastRaysRequest request = cast_request(kScene, random_rays(5000, 3));
  request.add_fields(v1::HIT_FIELD_HIT);
  const std::string closest = column_of(api_.cast(request), v1::HIT_FIELD_HIT);
  request.set_kind(v1::QUERY_KIND_ANY);
  request.clear_fields();
  EXPECT_EQ(column_of(api_.cast(request), v1::HIT_FIELD_HIT), closest);
}

TEST_F(CastRpcTest, AFewRaysAreAnsweredAlikeOverBuiltAndDeferredCells) {
  api_.make_scene(kScene, random_soup(20000, 0.05, 12));
  const auto rays = random_rays(40 * server::queries::kImmediateCast, 4);
  std::vector<std::string> growing, built;
  std::uint64_t cells = 0;
  const auto ask = [&](std::vector<std::string>& answers) {
    cells = 0;
    for (std::size_t first = 0; first < rays.size(); first += server::queries::kImmediateCast) {
      v1::CastRaysRequest request =
          cast_request(kScene, std::span(rays).subspan(first, server::queries::kImmediateCast));
      for (const v1::QueryKind kind :
           {v1::QUERY_KIND_ANY, v1::QUERY_KIND_CLOSEST, v1::QUERY_KIND_COUNT}) {
        request.set_kind(kind);
        const v1::CastRaysResponse reply = api_.cast(request);
        EXPECT_EQ(reply.stats().rays(), server::queries::kImmediateCast);
        cells += reply.stats().cells_expanded();
        for (const v1::HitColumn& column : reply.columns()) answers.push_back(column.data());
      }
    }
  };
  ask(growing);
  EXPECT_GT(cells, 0u);
  ask(built);
  EXPECT_EQ(cells, 0u);
  EXPECT_EQ(growing, built);
  v1::CastRaysRequest all = cast_request(kScene, rays);
  all.set_build(v1::BUILD_MODE_FULL);
  const std::string t = column_of(api_.cast(all), v1::HIT_FIELD_T);
  for (std::size_t i = 0; i < 40; ++i) {
    const std::size_t bytes = server::queries::kImmediateCast * sizeof(double);
    EXPECT_EQ(built[5 * i + 1], t.substr(i * bytes, bytes)) << "any, t, node, primitive, count";
  }
}

TEST_F(CastRpcTest, RepliesWithTheRequestedFieldsOnly) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(10));
  const v1::CastRaysResponse standard = api_.cast(request);
  ASSERT_EQ(standard.columns_size(), 3);
  EXPECT_EQ(column_of(standard, v1::HIT_FIELD_T).size(), 80u);
  EXPECT_EQ(column_of(standard, v1::HIT_FIELD_NODE).size(), 80u);
  EXPECT_EQ(column_of(standard, v1::HIT_FIELD_PRIMITIVE).size(), 40u);
  request.add_fields(v1::HIT_FIELD_NORMAL);
  const v1::CastRaysResponse normal = api_.cast(request);
  ASSERT_EQ(normal.columns_size(), 1);
  EXPECT_EQ(column_of(normal, v1::HIT_FIELD_NORMAL).size(), 120u);
}

TEST_F(CastRpcTest, MarksBadRaysAndServesTheOthers) {
  api_.make_scene(kScene, planar_sheet(1));
  auto rays = rays_downward(4);
  rays[0].origin.x = std::numeric_limits<double>::quiet_NaN();
  rays[1].direction = {0, 0, 0};
  rays[2].direction.y = std::numeric_limits<double>::infinity();
  v1::CastRaysRequest request = cast_request(kScene, rays);
  ask_for_all(request);
  const v1::CastRaysResponse reply = api_.cast(request);
  EXPECT_EQ(column_of(reply, v1::HIT_FIELD_HIT), std::string("\2\2\2\1"));
  const auto hits = decode_hits(reply);
  EXPECT_TRUE(std::isnan(hits[0].t));
  EXPECT_EQ(hits[0].node, 0u);
  EXPECT_EQ(hits[3].t, 10);
  EXPECT_EQ(reply.stats().invalid(), 3u);
  EXPECT_EQ(reply.stats().hits(), 1u);
}

TEST_F(CastRpcTest, RefusesMoreGeneratedRaysThanARequestMayHave) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  v1::RayGenerator& generator = *request.mutable_generator();
  v1::SphericalScan& scan = *generator.mutable_scan();
  for (const double number : {0.5, 0.5, 3.0}) scan.add_origin(number);
  for (const double number : {1, 0, 0}) scan.add_forward(number);
  for (const double number : {0, 1, 0}) scan.add_left(number);
  for (const double number : {0, 0, 1}) scan.add_up(number);
  for (const double number : {0.0, 6.25}) scan.add_azimuth(number);
  for (const double number : {-1.5, 1.5}) scan.add_elevation(number);
  scan.set_columns(1 << 20);
  scan.set_rows(1 << 20);
  v1::CastRaysResponse reply;
  const grpc::Status all = api_.cast(request, &reply);
  EXPECT_EQ(all.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(all.error_message().find("the request has 1099511627776 rays, the limit is 16384"),
            std::string::npos)
      << all.error_message();
  generator.set_first(std::uint64_t{1} << 30);
  generator.set_count(server::queries::kMaxRaysPerRequest);
  EXPECT_EQ(api_.cast(request).stats().rays(), server::queries::kMaxRaysPerRequest);
  scan.clear_up();
  const grpc::Status bad = api_.cast(request, &reply);
  EXPECT_EQ(bad.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(reason_of(bad), "NUMBER_COUNT");
}

TEST_F(CastRpcTest, AcceptsFloat32Columns) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  const float origin[] = {0.25f, 0.5f, 3}, direction[] = {0, 0, -2};
  request.mutable_rays()->set_origins(origin, sizeof(origin));
  request.mutable_rays()->set_directions(direction, sizeof(direction));
  request.add_fields(v1::HIT_FIELD_T);
  const double t = 1.5;
  EXPECT_EQ(column_of(api_.cast(request), v1::HIT_FIELD_T),
            std::string(reinterpret_cast<const char*>(&t), sizeof(t)));
}

TEST_F(CastRpcTest, AnEmptySceneAndAnEmptyBatchAreAnswered) {
  ASSERT_TRUE(api_.create(kScene).ok());
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(3));
  request.add_fields(v1::HIT_FIELD_HIT);
  const v1::CastRaysResponse missed = api_.cast(request);
  EXPECT_EQ(column_of(missed, v1::HIT_FIELD_HIT), std::string(3, '\0'));
  EXPECT_EQ(missed.served().revision(), 0u);
  request.clear_rays();
  EXPECT_EQ(api_.cast(request).columns(0).data(), "");
}

TEST_F(CastRpcTest, RefusesTooManyRaysByNumber) {
  api_.make_scene(kScene, planar_sheet(1));
  const grpc::Status status =
      fail(cast_request(kScene, rays_downward(server::queries::kMaxRaysPerRequest + 1)));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(reason_of(status), "TOO_MANY_RAYS");
  EXPECT_NE(status.error_message().find("16385 rays, the limit is 16384"), std::string::npos);
  EXPECT_EQ(api_.cast(cast_request(kScene, rays_downward(server::queries::kMaxRaysPerRequest)))
                .stats()
                .rays(),
            server::queries::kMaxRaysPerRequest);
}

TEST_F(CastRpcTest, RefusesBadRequests) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(3));
  request.set_scene("projects/p/scenes/none");
  EXPECT_EQ(fail(request).error_code(), grpc::StatusCode::NOT_FOUND);
  request.set_scene("none");
  EXPECT_EQ(fail(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  request.set_scene(kScene);
  request.mutable_rays()->mutable_directions()->pop_back();
  EXPECT_EQ(reason_of(fail(request)), "COLUMN_LENGTH");
}

TEST_F(CastRpcTest, GrowsOnlyAsTheBuildModeAllows) {
  api_.make_scene(kScene, planar_sheet(64));
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(100));
  request.set_build(v1::BUILD_MODE_NONE);
  EXPECT_EQ(api_.cast(request).stats().cells_expanded(), 0u);
  EXPECT_EQ(api_.stats(kScene).triangles_built(), 0u);

  request.set_build(v1::BUILD_MODE_UNSPECIFIED);
  EXPECT_GT(api_.cast(request).stats().cells_expanded(), 0u);
  EXPECT_EQ(api_.cast(request).stats().cells_expanded(), 0u) << "the same rays again";
  const auto lazy = api_.stats(kScene);
  EXPECT_GT(lazy.triangles_built(), 0u);
  EXPECT_LT(lazy.triangles_built(), lazy.triangles_total() / 2);

  request.set_build(v1::BUILD_MODE_FULL);
  api_.cast(request);
  const auto full = api_.stats(kScene);
  EXPECT_EQ(full.cells_deferred(), 0u);
  EXPECT_EQ(full.triangles_built(), full.triangles_total());
}

TEST_F(CastRpcTest, ManyClientsGetTheSameHitsOfAColdScene) {
  api_.make_scene(kScene, random_soup(5000, 0.1, 5));
  const v1::CastRaysRequest request = cast_request(kScene, random_rays(4000, 3));
  std::vector<v1::CastRaysResponse> replies(8);
  std::vector<std::thread> clients;
  for (auto& reply : replies) {
    clients.emplace_back(
        [&] { EXPECT_TRUE(Api(connect(server_->port())).cast(request, &reply).ok()); });
  }
  for (auto& client : clients) client.join();
  for (const auto& reply : replies) {
    for (int c = 0; c < 3; ++c) EXPECT_EQ(reply.columns(c).data(), replies[0].columns(c).data());
  }
}

TEST_F(CastRpcTest, AnExpiredDeadlineIsReported) {
  api_.make_scene(kScene, planar_sheet(1));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() - std::chrono::seconds(1));
  v1::CastRaysResponse reply;
  EXPECT_EQ(
      api_.rays->CastRays(&context, cast_request(kScene, rays_downward(10)), &reply).error_code(),
      grpc::StatusCode::DEADLINE_EXCEEDED);
  api_.cast(cast_request(kScene, rays_downward(10)));
}

server::ServerConfig with_full_policy() {
  server::ServerConfig config = test_config();
  config.policy = scenegraph::Growth::kFull;
  return config;
}

class FullPolicyTest : public CastRpcTest {
 protected:
  FullPolicyTest() : CastRpcTest(with_full_policy()) {}
};

TEST_F(FullPolicyTest, BuildsEverythingBeforeTheFirstRay) {
  api_.make_scene(kScene, planar_sheet(64));
  api_.cast(cast_request(kScene, rays_downward(1)));
  const auto stats = api_.stats(kScene);
  EXPECT_EQ(stats.cells_deferred(), 0u);
  EXPECT_EQ(stats.triangles_built(), stats.triangles_total());
}

server::ServerConfig with_short_queue() {
  server::ServerConfig config = test_config();
  config.admission.rays = 100;
  return config;
}

class ShortQueueTest : public CastRpcTest {
 protected:
  ShortQueueTest() : CastRpcTest(with_short_queue()) {}
};

TEST_F(ShortQueueTest, RefusesABatchAboveTheLimitAndNamesIt) {
  api_.make_scene(kScene, planar_sheet(1));
  const grpc::Status status = fail(cast_request(kScene, rays_downward(101)));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(reason_of(status), "QUEUE_FULL");
  EXPECT_NE(status.error_message().find("101 more"), std::string::npos);
  EXPECT_NE(status.error_message().find("limit of 100"), std::string::npos);
  for (int i = 0; i < 10; ++i) api_.cast(cast_request(kScene, rays_downward(100)));
}

TEST_F(ShortQueueTest, BatchesThatListHitsLeaveCapacityForOthers) {
  api_.make_scene(kScene, planar_sheet(1));
  const auto all_of = [&](std::size_t rays) {
    auto request = cast_request(kScene, rays_downward(rays));
    request.set_kind(v1::QUERY_KIND_ALL);
    return request;
  };
  const grpc::Status status = fail(all_of(51));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(reason_of(status), "QUEUE_FULL");
  EXPECT_NE(status.error_message().find("limit of 50"), std::string::npos);
  for (int i = 0; i < 3; ++i) api_.cast(all_of(50));
}

}  // namespace
}  // namespace sightline::tests
