// A scene from the arrays of a program.
#include <gtest/gtest.h>

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "client/client.h"
#include "tests/client/support/live_client.h"

namespace sightline::client {
namespace {

using ImportArrays = tests::LiveClient;
using tests::kScene;

const std::vector<float> kCorners{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
const std::vector<std::uint32_t> kTriangles{0, 1, 2, 0, 2, 3};
const std::vector<Vertex> kVertexRows{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
const std::vector<Face> kFaceRows{{0, 1, 2}, {0, 2, 3}};

TEST_F(ImportArrays, ArraysAreHit) {
  const auto made = client_.import_arrays(kScene, kCorners, kTriangles,
                                          {.up_axis = UpAxis::kZ, .meters_per_unit = 2});
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->revision, 1U);
  EXPECT_EQ(made->triangles_unique, 2U);
  EXPECT_EQ(made->up_axis, UpAxis::kZ);
  EXPECT_EQ(made->meters_per_unit, 2);
  const tests::DownwardRays rays(1, 1);
  std::vector<double> t(1);
  std::vector<std::uint64_t> node(1);
  std::vector<std::string> name(1);
  const HitColumns hits{.t = t, .node = node, .name = name};
  ASSERT_TRUE(client_.cast(kScene, rays.columns(), hits));
  EXPECT_EQ(t[0], 5);
  EXPECT_EQ(node[0], 1U);
  EXPECT_EQ(name[0], "mesh");
}

TEST_F(ImportArrays, RowsAndNumbersAreTheSameMesh) {
  ASSERT_TRUE(client_.import_arrays(kScene, kCorners, kTriangles));
  const char* const other = "projects/default/scenes/rows";
  ASSERT_TRUE(client_.import_arrays(other, kVertexRows, kFaceRows));
  const std::vector<std::uint64_t> id{1};
  EXPECT_EQ(client_.get_nodes(kScene, id)->front().mesh_digest,
            client_.get_nodes(other, id)->front().mesh_digest);
}

TEST_F(ImportArrays, ASceneIsReplacedOnlyIfAsked) {
  ASSERT_TRUE(client_.import_arrays(kScene, kVertexRows, kFaceRows));
  const std::vector<Face> one{{0, 1, 2}};
  const auto there = client_.import_arrays(kScene, kVertexRows, one);
  ASSERT_FALSE(there);
  EXPECT_EQ(there.error().code, Code::kAlreadyExists);
  EXPECT_EQ(there.error().reason, "SCENE_EXISTS");
  EXPECT_EQ(client_.get_scene(kScene)->triangles_unique, 2U);
  ASSERT_TRUE(client_.import_arrays(kScene, kVertexRows, one, {.replace = true}));
  EXPECT_EQ(client_.get_scene(kScene)->triangles_unique, 1U);
}

TEST_F(ImportArrays, WhatIsNoMeshIsNotSent) {
  const auto error_of = [&](std::vector<float> vertices, std::vector<std::uint32_t> faces) {
    const auto made = client_.import_arrays(kScene, vertices, faces);
    EXPECT_FALSE(made);
    return made ? Error{} : made.error();
  };
  Error error = error_of({1, 2, 3, 4}, kTriangles);
  EXPECT_EQ(error.code, Code::kInvalidArgument);
  EXPECT_EQ(error.message, "vertices have 4 numbers: not 3 each");
  EXPECT_EQ(error_of(kCorners, {0, 1}).message, "faces have 2 numbers: not 3 each");
  error = error_of(kCorners, {0, 1, 2, 0, 4, 3});
  EXPECT_EQ(error.message, "face 1 has vertex 4, but there are 4 vertices");
  EXPECT_EQ(error.reason, "NO_SUCH_VERTEX");
  EXPECT_EQ(error_of(kCorners, {0, 1, kNoVertex}).reason, "NO_SUCH_VERTEX");
  EXPECT_EQ(error_of(kCorners, {}).reason, "NO_FACES");
  EXPECT_EQ(client_.get_scene(kScene).error().code, Code::kNotFound);
}

TEST_F(ImportArrays, AFaceWithoutVerticesKeepsItsNumber) {
  const std::vector<Face> faces{{kNoVertex, kNoVertex, kNoVertex}, {0, 1, 2}};
  ASSERT_TRUE(client_.import_arrays(kScene, kVertexRows, faces));
  const tests::DownwardRays rays(1, 1);
  std::vector<std::uint32_t> primitive(1);
  ASSERT_TRUE(client_.cast(kScene, rays.columns(), {.primitive = primitive}));
  EXPECT_EQ(primitive[0], 1U);
}

TEST_F(ImportArrays, AStopLeavesNoScene) {
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = client_.import_arrays(kScene, kVertexRows, kFaceRows,
                                             {.replace = true, .stop = stop.get_token()});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Code::kCancelled);
  EXPECT_EQ(client_.get_scene(kScene).error().code, Code::kNotFound);
}

}  // namespace
}  // namespace sightline::client
