// Prefetches of scenes for whose shards servers answer.
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/server/replicas/shards.h"

namespace sightline::tests {
namespace {

class ShardedPrefetch : public Shards {
 protected:
  static constexpr int kCubes = 12;

  /// Cubes in a row, each of a mesh of its own.
  void make_row() {
    Api& writer = plain_->api();
    ASSERT_TRUE(writer.create(kScene).ok());
    std::vector<v1::Update> updates;
    for (int i = 0; i < kCubes; ++i) {
      const float size = 1 + 0.01F * static_cast<float>(i);
      updates.push_back(put_node(-1 - i, writer.add_mesh(cube(-size, size)), 0, at(4 * i, 0, 0)));
    }
    ASSERT_TRUE(writer.apply(kScene, updates).ok());
  }

  static v1::PrefetchRequest request() {
    v1::PrefetchRequest request;
    request.set_scene(kScene);
    return request;
  }
  static v1::PrefetchRequest request_for(std::span<const accel::geometry::Ray> rays,
                                         v1::QueryKind kind) {
    v1::PrefetchRequest asked = request();
    *asked.mutable_rays() = cast_request(kScene, rays).rays();
    asked.set_kind(kind);
    return asked;
  }

  /// The last report.
  static v1::PrefetchResponse prefetch(Api& api, const v1::PrefetchRequest& asked,
                                       grpc::Status* status) {
    grpc::ClientContext context;
    v1::PrefetchResponse report, last;
    const auto call = api.rays->Prefetch(&context, asked);
    while (call->Read(&report)) {
      EXPECT_LE(last.meshes_done(), report.meshes_done());
      EXPECT_LE(last.cells_expanded(), report.cells_expanded());
      EXPECT_LE(last.rays_done(), report.rays_done());
      last = report;
    }
    *status = call->Finish();
    return last;
  }
  static v1::PrefetchResponse prefetched(Api& api, const v1::PrefetchRequest& asked) {
    grpc::Status status;
    v1::PrefetchResponse last = prefetch(api, asked, &status);
    EXPECT_TRUE(status.ok()) << status.error_message();
    EXPECT_TRUE(last.done());
    return last;
  }
  static std::string refused(Api& api, const v1::PrefetchRequest& asked) {
    grpc::Status status;
    EXPECT_FALSE(prefetch(api, asked, &status).done());
    return reason_of(status);
  }

  /// Cells that a cast expands, over all servers.
  std::uint64_t expanded_by(v1::QueryKind kind, std::span<const accel::geometry::Ray> cast) {
    v1::CastRaysResponse reply;
    EXPECT_TRUE(api(0).cast(cast_of(kind, cast), &reply).ok());
    return reply.stats().cells_expanded();
  }
};

TEST_F(ShardedPrefetch, BuildsAtEachServerTheTreesOfItsShard) {
  start_shards();
  make_row();
  const v1::PrefetchResponse last = prefetched(api(1), request());
  for (std::size_t i = 0; i < kServers; ++i)
    EXPECT_EQ(api(i).stats(kScene).triangles_built(), 4 * 12u) << "a third of them";
  EXPECT_EQ(last.meshes_done(), 12u);
  EXPECT_EQ(last.meshes_total(), 12u);
  EXPECT_EQ(last.triangles_done(), 12 * 12u);
  EXPECT_EQ(last.triangles_total(), 12 * 12u);
  EXPECT_GT(last.cells_expanded(), 0u);
  EXPECT_GT(last.bytes_trees(), 0u);
  EXPECT_EQ(last.served().revision(), 1u);
  EXPECT_EQ(expanded_by(v1::QUERY_KIND_COUNT, rays()), 0u);
}

TEST_F(ShardedPrefetch, OfSomeNodesBuildsTheirTreesAlone) {
  start_shards();
  make_row();
  v1::PrefetchRequest some = request();
  some.add_roots(1);
  some.add_roots(12);
  some.add_roots(5);
  some.add_exclude(5);
  EXPECT_EQ(prefetched(api(2), some).meshes_done(), 2u);
  std::uint64_t built = 0;
  for (std::size_t i = 0; i < kServers; ++i) built += api(i).stats(kScene).triangles_built();
  EXPECT_EQ(built, 2 * 12u);
}

TEST_F(ShardedPrefetch, OfRaysBuildsWhatTheirCastWould) {
  start_shards();
  make_grid();
  const auto many = rays(6000);  // more than a part
  const v1::PrefetchResponse last = prefetched(api(0), request_for(many, v1::QUERY_KIND_CLOSEST));
  EXPECT_EQ(last.rays_done(), many.size());
  EXPECT_EQ(last.rays_total(), many.size());
  EXPECT_GT(last.cells_expanded(), 0u);
  EXPECT_EQ(expanded_by(v1::QUERY_KIND_CLOSEST, many), 0u);
  for (const v1::QueryKind kind : {v1::QUERY_KIND_ALL, v1::QUERY_KIND_COUNT, v1::QUERY_KIND_ANY}) {
    prefetched(api(1), request_for(many, kind));
    EXPECT_EQ(expanded_by(kind, std::span(many).first(500)), 0u) << kind;
  }
  EXPECT_EQ(prefetched(api(1), request_for({}, v1::QUERY_KIND_CLOSEST)).rays_done(), 0u);
}

TEST_F(ShardedPrefetch, OfOneShardBuildsThatOne) {
  start_shards();
  make_row();
  v1::PrefetchRequest one = request();
  one.mutable_shard()->set_count(kServers);
  one.mutable_shard()->set_index(2);
  EXPECT_EQ(prefetched(api(0), one).meshes_done(), 4u);
  EXPECT_EQ(api(1).stats(kScene).triangles_built(), 0u) << "the others are not asked";
  EXPECT_EQ(refused(plain_->api(), one), "SHARDS_DIFFER");
  one.mutable_shard()->set_index(kServers);
  EXPECT_EQ(refused(api(0), one), "BAD_SHARD");
}

TEST_F(ShardedPrefetch, SaysWhatDoesNotExist) {
  start_shards();
  make_row();
  v1::PrefetchRequest wrong = request();
  wrong.add_roots(99);
  EXPECT_EQ(refused(api(0), wrong), "NODE_NOT_FOUND");
  wrong = request_for(rays(5), v1::QUERY_KIND_CLOSEST);
  wrong.add_exclude(99);
  EXPECT_EQ(refused(api(0), wrong), "NODE_NOT_FOUND");
  wrong = request();
  wrong.set_scene("projects/default/scenes/absent");
  EXPECT_EQ(refused(api(0), wrong), "SCENE_NOT_FOUND");
}

TEST_F(ShardedPrefetch, FailsWithoutOneOfTheServers) {
  start_shards();
  make_row();
  servers_[1].reset();
  EXPECT_EQ(refused(api(0), request()), "SHARD_LOST");
  EXPECT_EQ(refused(api(0), request_for(rays(), v1::QUERY_KIND_COUNT)), "SHARD_LOST");
  start_shard(1);
  wait_until([&] {
    grpc::Status status;
    return prefetch(api(0), request(), &status).done();
  });
}

TEST_F(ShardedPrefetch, EndsWithItsCaller) {
  start_shards();
  make_row();
  for (int i = 0; i < 20; ++i) {
    grpc::ClientContext context;
    v1::PrefetchResponse report;
    const auto call = api(0).rays->Prefetch(&context, request());
    if (i % 2 == 0) call->Read(&report);
    context.TryCancel();
    call->Finish();
  }
  prefetched(api(0), request());
}

TEST_F(ShardedPrefetch, EndsWithItsServer) {
  start_shards();
  make_row();
  const auto rays = v1::RayQueryService::NewStub(
      grpc::CreateChannel(address(0), grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  v1::PrefetchResponse report;
  const auto call = rays->Prefetch(&context, request());
  call->WaitForInitialMetadata();
  servers_[0].reset();
  bool done = false;
  while (call->Read(&report)) done = report.done();
  EXPECT_EQ(call->Finish().ok(), done);
}

}  // namespace
}  // namespace sightline::tests
