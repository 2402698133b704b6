// Millimeters at ten thousand kilometers from the origin, through client, wire and server; and a
// far scene with and without the importer's rebase.
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/importer/scene_from_file.h"
#include "client/scene_upload.h"
#include "server/server.h"
#include "tests/support/millimetres.h"

namespace sightline::tests {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;

constexpr double kTenthOfAMillimetre = 1e-4;
constexpr double kNudge = 1e-7;
constexpr std::size_t kRays = 20'000;

client::importer::ImportedScene plate_at(const Vec3d& position) {
  const TestMesh plate = ridged_plate();
  client::importer::ImportedMesh mesh;
  for (const accel::geometry::Vec3f& v : plate.vertices) mesh.vertices.push_back({v.x, v.y, v.z});
  mesh.faces = plate.faces;
  mesh.triangles = mesh.faces.size();
  client::importer::ImportedScene scene;
  scene.meshes.push_back(std::move(mesh));
  scene.nodes.push_back(
      {.name = "plate",
       .parent_from_local = {1, 0, 0, position.x, 0, 1, 0, position.y, 0, 0, 1, position.z},
       .mesh = 0});
  return scene;
}

// A file of this scene, which has one mesh.
client::importer::FileScene file_of(const client::importer::ImportedScene& scene) {
  client::importer::FileScene file;
  client::importer::FileMesh& mesh = file.meshes.emplace_back();
  for (const client::Vertex& v : scene.meshes[0].vertices) {
    mesh.vertices.push_back(
        {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])});
  }
  for (const client::Face& face : scene.meshes[0].faces) {
    mesh.faces.corners.insert(mesh.faces.corners.end(), face.begin(), face.end());
    mesh.faces.first.push_back(static_cast<std::uint32_t>(mesh.faces.corners.size()));
  }
  file.nodes.push_back({.name = "plate", .meshes = {0}});
  return file;
}

std::vector<Ray> moved(std::vector<Ray> rays, const Vec3d& by) {
  for (Ray& ray : rays) ray.origin = ray.origin + by;
  return rays;
}

class Millimetres : public testing::Test {
 protected:
  void SetUp() override {
    spdlog::set_level(spdlog::level::err);
    server::ServerConfig config;
    config.listen = "127.0.0.1:0";
    auto started = server::Server::start(config);
    ASSERT_TRUE(started.ok()) << started.error().message;
    server_ = *std::move(started);
    auto connected = client::Client::connect("127.0.0.1:" + std::to_string(server_->port()));
    ASSERT_TRUE(connected.ok()) << connected.error().message;
    client_.emplace(std::move(*connected));
  }

  void upload(const char* name, const client::importer::ImportedScene& scene) {
    const auto uploaded = client::upload_scene(*client_, name, scene, {});
    ASSERT_TRUE(uploaded.ok()) << uploaded.error().message;
  }

  std::vector<Hit> cast(const char* name, std::span<const Ray> rays) {
    std::vector<double> origins, directions, t(rays.size());
    for (const Ray& ray : rays) {
      origins.insert(origins.end(), {ray.origin.x, ray.origin.y, ray.origin.z});
      directions.insert(directions.end(), {ray.direction.x, ray.direction.y, ray.direction.z});
    }
    std::vector<std::uint32_t> primitive(rays.size());
    std::vector<std::uint8_t> hit(rays.size());
    const auto report =
        client_->cast_stream(name, client::RayColumns<const double>{origins, directions},
                             {.t = t, .primitive = primitive, .hit = hit});
    EXPECT_TRUE(report.ok()) << report.error().message;
    std::vector<Hit> hits(rays.size());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      hits[i].t = t[i];
      hits[i].primitive = primitive[i];
      hits[i].state = static_cast<accel::geometry::HitState>(hit[i]);
    }
    return hits;
  }

  static constexpr const char* kHere = "projects/default/scenes/here";
  static constexpr const char* kThere = "projects/default/scenes/there";
  std::unique_ptr<server::Server> server_;
  std::optional<client::Client> client_;
};

TEST_F(Millimetres, AreHitTenThousandKilometersAwayAsAtTheOrigin) {
  const Vec3d far{1e7 + 1.0 / 3, -1e7 - 0.7, 1e7 + 0.1};
  ASSERT_NO_FATAL_FAILURE(upload(kHere, plate_at({0, 0, 0})));
  ASSERT_NO_FATAL_FAILURE(upload(kThere, plate_at(far)));
  const std::vector<Ray> rays = with_nudges(kilometre_rays(kRays, 1, 40), kNudge);
  const Displacement d = displacement(cast(kHere, rays), cast(kThere, moved(rays, far)));
  EXPECT_EQ(d.rays, kRays);
  EXPECT_EQ(d.missed, 0u) << d.report();
  EXPECT_EQ(d.others, 0u) << d.report();
  EXPECT_LT(d.largest_t_error, kTenthOfAMillimetre) << d.report();
  EXPECT_GT(d.steady, d.rays * 9 / 10) << d.report();
  std::cout << d.report() << "\n";
}

// The content of a file of this plate at one kilometer: floats with a spacing of an eighth of a
// millimeter.
TEST_F(Millimetres, ARebasedFileGivesTheSameAnswers) {
  const Vec3d far{1024, 0, -1024};
  client::importer::ImportedScene stood = plate_at({0, 0, 0});
  for (client::Vertex& v : stood.meshes[0].vertices) {
    v[0] += static_cast<float>(far.x);
    v[2] += static_cast<float>(far.z);
  }
  const auto brought = client::importer::scene_from_file(file_of(stood), {});
  ASSERT_TRUE(brought.ok()) << brought.error().message;
  ASSERT_EQ(brought->rig.offsets.at(0), (std::array<double, 3>{far.x, 0, far.z}));
  ASSERT_NO_FATAL_FAILURE(upload(kHere, stood));
  ASSERT_NO_FATAL_FAILURE(upload(kThere, brought->scene));
  const std::vector<Ray> rays = moved(kilometre_rays(kRays, 2, 30), far);
  const std::vector<Hit> a = cast(kHere, rays), b = cast(kThere, rays);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(a[i].state, b[i].state) << "ray " << i;
    ASSERT_EQ(std::memcmp(&a[i].t, &b[i].t, sizeof a[i].t), 0) << "ray " << i;
    ASSERT_EQ(a[i].primitive, b[i].primitive) << "ray " << i;
    hits += a[i].state == accel::geometry::HitState::kHit ? 1 : 0;
  }
  EXPECT_EQ(hits, rays.size());
}

}  // namespace
}  // namespace sightline::tests
