// Servers that each answer for a shard of a scene, and one that answers for all of it, for tests.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/client/support/temp_dir.h"
#include "tests/server/replicas/replicas.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// What is asked for of each kind, but WORK, which is a sum over servers.
inline const std::map<v1::QueryKind, std::vector<v1::HitField>> kFields{
    {v1::QUERY_KIND_CLOSEST,
     {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_BARYCENTRIC,
      v1::HIT_FIELD_NORMAL, v1::HIT_FIELD_HIT, v1::HIT_FIELD_POSITION, v1::HIT_FIELD_NAME}},
    {v1::QUERY_KIND_ANY, {v1::HIT_FIELD_HIT_BITS}},
    {v1::QUERY_KIND_COUNT, {v1::HIT_FIELD_COUNT, v1::HIT_FIELD_HIT}},
    {v1::QUERY_KIND_ALL,
     {v1::HIT_FIELD_OFFSET, v1::HIT_FIELD_HIT, v1::HIT_FIELD_T, v1::HIT_FIELD_NODE,
      v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_NORMAL,
      v1::HIT_FIELD_POSITION, v1::HIT_FIELD_NAME}}};

inline v1::CastRaysRequest cast_of(v1::QueryKind kind, std::span<const accel::geometry::Ray> rays) {
  v1::CastRaysRequest request = cast_request(kScene, rays);
  request.set_kind(kind);
  for (const v1::HitField field : kFields.at(kind)) request.add_fields(field);
  if (kind == v1::QUERY_KIND_ALL) request.set_max_hits(6);
  return request;
}

inline scenegraph::model::Affine at(double x, double y, double z) {
  return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}

inline v1::QueryPointsRequest nearest_of(v1::QueryKind kind,
                                         std::span<const accel::geometry::Ray> points) {
  v1::QueryPointsRequest request;
  request.set_scene(kScene);
  request.set_kind(kind);
  for (const v1::HitField field : kFields.at(kind)) request.add_fields(field);
  if (kind == v1::QUERY_KIND_ALL) request.set_max_hits(6);
  v1::Points& columns = *request.mutable_points();
  columns.set_float64(true);
  const auto append = [](std::string& column, const auto& value) {
    column.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  for (const accel::geometry::Ray& point : points) {
    append(*columns.mutable_positions(), point.origin);
    append(*columns.mutable_max_distance(), point.tmax);
  }
  return request;
}

class Shards : public ReplicaTest {
 protected:
  static constexpr std::size_t kServers = 3;

  void SetUp() override {
    ReplicaTest::SetUp();
    if (IsSkipped()) return;
    plain_ = start();
  }

  std::string address(std::size_t shard) const {
    return "unix:" + sockets_.path("s" + std::to_string(shard));
  }
  void start_shard(std::size_t shard) {
    servers_[shard] = start([&](server::ServerConfig& config) {
      config.listen = address(shard);
      config.shard_peers = address(0) + "," + address(1) + "," + address(2);
    });
  }
  void start_shards() {
    for (std::size_t i = 0; i < kServers; ++i) start_shard(i);
  }
  Api& api(std::size_t shard) { return servers_[shard]->api(); }

  /// Spheres and cubes, some of them under a group, with names and labels. Each has transform(i).
  template <class Transform>
  void make_scene(int nodes, const Transform& transform) {
    Api& writer = plain_->api();
    ASSERT_TRUE(writer.create(kScene).ok());
    const std::string meshes[] = {writer.add_mesh(icosphere(2)), writer.add_mesh(cube())};
    std::vector<v1::Update> updates{put_node(-1, std::string(), 0, at(0.5, 0, 0))};
    for (int i = 0; i < nodes; ++i) {
      updates.push_back(put_node(-2 - i, meshes[i % 2], i % 3 == 0 ? -1 : 0, transform(i)));
      updates.back().mutable_put_node()->set_name("node " + std::to_string(i));
      v1::Label& label = *updates.back().mutable_put_node()->add_labels();
      label.set_key("color");
      label.set_value(i % 5 < 2 ? "red" : "blue");
    }
    const grpc::Status applied = writer.apply(kScene, updates);
    ASSERT_TRUE(applied.ok()) << applied.error_message();
  }
  void make_grid() {
    make_scene(36, [](int i) { return at(4 * (i % 6), 4 * (i / 6), i % 4); });
  }

  /// Through the grid, in all directions; some invalid, some limited.
  static std::vector<accel::geometry::Ray> rays(std::size_t count = 500) {
    Random random(17);
    const auto point = [&] {
      return accel::geometry::Vec3d{random.uniform(-3, 25), random.uniform(-3, 25),
                                    random.uniform(-3, 6)};
    };
    std::vector<accel::geometry::Ray> rays(count);
    for (accel::geometry::Ray& ray : rays) {
      ray.origin = point();
      ray.direction = point() - ray.origin;
      if (random.below(3) == 0) ray.tmax = random.uniform(0, 1);
    }
    rays[3].direction = {};
    rays[4].tmin = std::nan("");
    return rays;
  }

  /// Everything but the stats and the work.
  template <class Request>
  static std::string answer(Api& api, Request request, const std::string& token = {}) {
    if (!token.empty()) request.mutable_consistency()->set_at_least(token);
    std::conditional_t<std::is_same_v<Request, v1::CastRaysRequest>, v1::CastRaysResponse,
                       v1::QueryPointsResponse>
        reply;
    const grpc::Status cast = api.cast(request, &reply);
    EXPECT_TRUE(cast.ok()) << cast.error_message();
    EXPECT_GT(reply.stats().rays(), 0u);
    std::string counts;
    for (const std::uint64_t count :
         {reply.stats().rays(), reply.stats().hits(), reply.stats().invalid(),
          reply.stats().hits_found(), reply.stats().rays_cut_off()})
      counts += std::to_string(count) + " ";
    reply.clear_stats();
    return counts + reply.SerializeAsString();
  }

  template <class Request>
  void expect_as_one_server(const Request& request, const std::string& token = {}) {
    const std::string whole = answer(plain_->api(), request, token);
    for (std::size_t i = 0; i < kServers; ++i)
      EXPECT_EQ(whole, answer(api(i), request, token)) << request.kind() << " at server " << i;
  }
  void expect_as_one_server(const std::vector<accel::geometry::Ray>& rays,
                            const std::string& token = {}) {
    for (const auto& [kind, fields] : kFields) expect_as_one_server(cast_of(kind, rays), token);
  }
  void expect_near_as_one_server(const std::vector<accel::geometry::Ray>& points,
                                 const std::string& token = {}) {
    for (const auto& [kind, fields] : kFields)
      expect_as_one_server(nearest_of(kind, points), token);
  }

  TempDir sockets_;
  std::unique_ptr<ReplicaServer> plain_;
  std::array<std::unique_ptr<ReplicaServer>, kServers> servers_;
};

}  // namespace sightline::tests
