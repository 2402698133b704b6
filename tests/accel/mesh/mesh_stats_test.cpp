// The statistics of meshes with and without irregular faces.
#include "accel/mesh/mesh_stats.h"

#include <gtest/gtest.h>

#include <limits>

#include "accel/mesh/face_boxes.h"
#include "tests/support/scenes.h"

namespace sightline::accel::mesh {
namespace {

using tests::TestMesh;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr geometry::Face kNoFace{geometry::kNoVertex, geometry::kNoVertex, geometry::kNoVertex};

/// One face at a time.
MeshStats slowly(const TestMesh& mesh) {
  MeshStats survey;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const FaceSum face = sum_faces(mesh.view(), i, i + 1);
    survey.triangles += face.triangles;
    survey.finite_triangles += face.finite;
    survey.first_bad_face = std::min(survey.first_bad_face, face.first_bad);
    if (face.finite > 0) survey.bounds.grow(face.box);
  }
  return survey;
}

void expect_right(const TestMesh& mesh, const MeshStats& survey) {
  const MeshStats expected = slowly(mesh);
  EXPECT_EQ(survey.triangles, expected.triangles);
  EXPECT_EQ(survey.finite_triangles, expected.finite_triangles);
  EXPECT_EQ(survey.first_bad_face, expected.first_bad_face);
  const geometry::Aabb bounds = padded(survey.bounds);
  geometry::Aabb both = bounds;
  if (expected.finite_triangles > 0) both.grow(expected.bounds);
  EXPECT_EQ(both, bounds);
}

TEST(MeshStats, EqualsASurveyFaceByFace) {
  for (const std::uint32_t side : {1u, 5u, 40u, 300u}) {
    TestMesh mesh = tests::planar_sheet(side);
    const MeshStats survey = compute_mesh_stats(mesh.view());
    expect_right(mesh, survey);
    EXPECT_EQ(survey.bounds.hi.x, static_cast<float>(side));
    mesh.faces.push_back(kNoFace);
    expect_right(mesh, compute_mesh_stats(mesh.view()));
    mesh.faces.push_back({0, 1, static_cast<std::uint32_t>(mesh.vertices.size())});
    expect_right(mesh, compute_mesh_stats(mesh.view()));
    mesh.faces.resize(mesh.faces.size() - 2);
    mesh.vertices[side].y = kNan;
    expect_right(mesh, compute_mesh_stats(mesh.view()));
  }
}

TEST(MeshStats, OfAnEmptyMesh) {
  expect_right({}, compute_mesh_stats({}));
  EXPECT_TRUE(compute_mesh_stats({}).bounds.empty());
  const TestMesh points{{{0, 0, 0}, {1, 1, 1}}, {kNoFace}};
  expect_right(points, compute_mesh_stats(points.view()));
  EXPECT_TRUE(compute_mesh_stats(points.view()).bounds.empty());
}

TEST(MeshStats, VerticesFarFromTheFacesDoNotCount) {
  TestMesh mesh = tests::planar_sheet(60);
  mesh.vertices.push_back({60000, 60000, 60000});
  EXPECT_EQ(compute_mesh_stats(mesh.view()).bounds.hi.x, 60.0f);
  mesh.vertices.back() = {kNan, 0, 0};
  EXPECT_EQ(compute_mesh_stats(mesh.view()).bounds.hi.x, 60.0f);
  EXPECT_EQ(compute_mesh_stats(mesh.view()).finite_triangles, mesh.faces.size());
}

TEST(MeshStats, FewLargeFacesAmongManySmallOnesCount) {
  TestMesh mesh = tests::planar_sheet(60);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{-9000, 0, 0}, {9000, 0, 0}, {0, 5000, 9000}});
  mesh.faces.insert(mesh.faces.begin() + 7, {first, first + 1, first + 2});
  expect_right(mesh, compute_mesh_stats(mesh.view()));
}

}  // namespace
}  // namespace sightline::accel::mesh
