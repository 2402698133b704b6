// A surface in surveyed coordinates that is cut into tiles: rays at the seams hit it once, however
// the tiles came in.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/importer/assimp_import.h"
#include "client/scene_upload.h"
#include "server/server.h"
#include "tests/client/support/temp_dir.h"
#include "tests/support/random.h"

namespace sightline::tests {
namespace {

using client::importer::ImportedNode;
using client::importer::ImportedScene;
using Position = std::array<double, 3>;

constexpr std::size_t kSeamRays = 3000;
constexpr const char* kSeamScene = "projects/default/scenes/seams";
// A grid of squares, in tiles of different sizes
constexpr std::size_t kGridCorners = 25;
constexpr std::size_t kGridCuts[] = {0, 3, 16, 24};

struct Ground {
  std::vector<Position> points;  // rows of kGridCorners

  const Position& at(std::size_t i, std::size_t j) const { return points[j * kGridCorners + i]; }
};

// Uneven ground of this size, in millimeters. `up` is the axis that is up.
Ground ground_at(const Position& corner, double size, std::size_t up, Random& random) {
  Ground ground;
  const double spacing = size / (kGridCorners - 1);
  for (std::size_t j = 0; j < kGridCorners; ++j) {
    for (std::size_t i = 0; i < kGridCorners; ++i) {
      const double across[] = {(static_cast<double>(i) + random.uniform(0, 0.3)) * spacing,
                               (static_cast<double>(j) + random.uniform(0, 0.3)) * spacing};
      Position p = corner;
      p[(up + 1) % 3] += across[0];
      p[(up + 2) % 3] += across[1];
      p[up] += random.uniform(0, 0.2) * spacing;
      for (double& x : p) x = std::round(x * 1000) / 1000;
      ground.points.push_back(p);
    }
  }
  return ground;
}

struct Tile {
  std::vector<Position> points;
  std::vector<std::array<std::size_t, 3>> faces;
};

std::vector<Tile> tiles_of(const Ground& ground) {
  std::vector<Tile> tiles;
  for (std::size_t v = 0; v + 1 < std::size(kGridCuts); ++v) {
    for (std::size_t u = 0; u + 1 < std::size(kGridCuts); ++u) {
      Tile tile;
      const std::size_t width = kGridCuts[u + 1] - kGridCuts[u] + 1;
      for (std::size_t j = kGridCuts[v]; j <= kGridCuts[v + 1]; ++j) {
        for (std::size_t i = kGridCuts[u]; i <= kGridCuts[u + 1]; ++i) {
          const std::size_t n = tile.points.size();
          tile.points.push_back(ground.at(i, j));
          if (i == kGridCuts[u + 1] || j == kGridCuts[v + 1]) continue;
          tile.faces.push_back({n, n + 1, n + width + 1});
          tile.faces.push_back({n, n + width + 1, n + width});
        }
      }
      tiles.push_back(std::move(tile));
    }
  }
  return tiles;
}

std::string obj(const std::vector<Tile>& tiles) {
  std::string text;
  std::size_t before = 1;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    text += fmt::format("o tile{}\n", t);
    for (const Position& p : tiles[t].points)
      text += fmt::format("v {:.3f} {:.3f} {:.3f}\n", p[0], p[1], p[2]);
    for (const auto& f : tiles[t].faces)
      text += fmt::format("f {} {} {}\n", f[0] + before, f[1] + before, f[2] + before);
    before += tiles[t].points.size();
  }
  return text;
}

std::string stl(const std::vector<Tile>& tiles) {
  std::string text;
  for (const Tile& tile : tiles) {
    text += "solid tile\n";
    for (const auto& face : tile.faces) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const std::size_t corner : face) {
        const Position& p = tile.points[corner];
        text += fmt::format("vertex {:.3f} {:.3f} {:.3f}\n", p[0], p[1], p[2]);
      }
      text += "endloop\nendfacet\n";
    }
    text += "endsolid tile\n";
  }
  return text;
}

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string ply(const Tile& tile) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double "
      "y\nproperty double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      tile.points.size(), tile.faces.size());
  for (const Position& p : tile.points) {
    for (const double x : p) append(bytes, x);
  }
  for (const auto& face : tile.faces) {
    bytes += '\3';
    for (const std::size_t corner : face) append(bytes, static_cast<std::int32_t>(corner));
  }
  return bytes;
}

// As several files are put into one scene.
void add(ImportedScene& scene, const ImportedScene& other) {
  const auto nodes = static_cast<std::uint32_t>(scene.nodes.size());
  const auto meshes = static_cast<std::uint32_t>(scene.meshes.size());
  for (ImportedNode node : other.nodes) {
    if (node.parent != client::importer::kNone) node.parent += nodes;
    if (node.mesh != client::importer::kNone) node.mesh += meshes;
    scene.nodes.push_back(std::move(node));
  }
  scene.meshes.insert(scene.meshes.end(), other.meshes.begin(), other.meshes.end());
}

class Seams : public testing::Test {
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

  ImportedScene import(const std::vector<std::string>& files, const char* ending) {
    ImportedScene scene;
    for (std::size_t i = 0; i < files.size(); ++i) {
      const auto one =
          client::importer::import_scene(folder_.write(fmt::format("{}.{}", i, ending), files[i]));
      EXPECT_TRUE(one) << one.error().message;
      if (!one) continue;
      for (const auto& warning : one->warnings) EXPECT_TRUE(warning.is_note) << warning.message;
      add(scene, *one);
    }
    return scene;
  }

  // Casts rays down at points of the seams, and counts those that do not hit once.
  void expect_no_gap(const ImportedScene& scene, const Ground& ground, std::size_t up,
                     std::uint64_t seed) {
    const auto uploaded = client::upload_scene(*client_, kSeamScene, scene, {.replace = true});
    ASSERT_TRUE(uploaded.ok()) << uploaded.error().message;
    Random random(seed);
    const double height = std::abs(ground.at(1, 1)[(up + 1) % 3] - ground.at(0, 0)[(up + 1) % 3]);
    std::vector<double> origins, directions;
    for (std::size_t r = 0; r < kSeamRays; ++r) {
      const std::size_t cut = kGridCuts[1 + random.below(std::size(kGridCuts) - 2)];
      const std::size_t along = 1 + random.below(kGridCorners - 3);
      const bool is_column = random.below(2) == 0;
      const Position& a = is_column ? ground.at(cut, along) : ground.at(along, cut);
      const Position& b = is_column ? ground.at(cut, along + 1) : ground.at(along + 1, cut);
      const double part = r % 10 == 0 ? 0 : random.uniform();
      for (std::size_t k = 0; k < 3; ++k) {
        const double at = a[k] + part * (b[k] - a[k]);
        const double from = at + height * (k == up      ? 3
                                           : r % 3 == 0 ? 0
                                                        : random.uniform(-0.4, 0.4));
        origins.push_back(from);
        directions.push_back(at - from);
      }
    }
    std::vector<std::uint32_t> counts(kSeamRays);
    const auto report =
        client_->cast_stream(kSeamScene, client::RayColumns<const double>{origins, directions},
                             {.count = counts}, {.kind = client::QueryKind::kCount});
    ASSERT_TRUE(report.ok()) << report.error().message;
    std::size_t lost = 0, doubled = 0;
    for (const std::uint32_t count : counts) {
      lost += count == 0;
      doubled += count > 1;
    }
    EXPECT_EQ(lost, 0U);
    EXPECT_EQ(doubled, 0U);
  }

  TempDir folder_;
  std::unique_ptr<server::Server> server_;
  std::optional<client::Client> client_;
};

struct Site {
  const char* name;
  Position corner;
  double size;
  std::size_t up;
};

constexpr Site kSurveySites[] = {{"UTM", {512345.678, 5412345.678, 412.345}, 900, 2},
                                 {"UTM, large", {388096.37, 3948996.81, 1641.25}, 3000, 2},
                                 {"UTM, small", {500000.001, 5400000.002, 7.3}, 30, 2},
                                 {"ECEF", {3875432.101, 332001.909, 5029123.456}, 700, 0}};

TEST_F(Seams, RaysHitTheGroundOnce) {
  Random random(1);
  for (const Site& site : kSurveySites) {
    const Ground ground = ground_at(site.corner, site.size, site.up, random);
    const std::vector<Tile> tiles = tiles_of(ground);
    std::vector<std::string> objs, plys, stls;
    for (const Tile& tile : tiles) {
      objs.push_back(obj({tile}));
      plys.push_back(ply(tile));
      stls.push_back(stl({tile}));
    }
    const auto check = [&](const char* how, const std::vector<std::string>& files,
                           const char* ending) {
      SCOPED_TRACE(fmt::format("{}: {}", site.name, how));
      expect_no_gap(import(files, ending), ground, site.up, 7);
    };
    check("one OBJ file of several objects", {obj(tiles)}, "obj");
    check("an OBJ file for each tile", objs, "obj");
    check("one STL file of several solids", {stl(tiles)}, "stl");
    check("an STL file for each tile", stls, "stl");
    check("a PLY file for each tile", plys, "ply");
  }
}

}  // namespace
}  // namespace sightline::tests
