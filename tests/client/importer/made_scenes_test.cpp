// Assimp scenes that no valid file produces.
#include "client/importer/file_scene_from_assimp.h"

#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/importer/scene_from_file.h"

namespace sightline::client::importer {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A root with a triangle.
std::unique_ptr<aiScene> triangle() {
  auto scene = std::make_unique<aiScene>();
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { new aiMesh };
  aiMesh& mesh = *scene->mMeshes[0];
  mesh.mNumVertices = 3;
  mesh.mVertices = new aiVector3D[3]{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.mNumFaces = 1;
  mesh.mFaces = new aiFace[1];
  mesh.mFaces[0].mNumIndices = 3;
  mesh.mFaces[0].mIndices = new unsigned[3]{0, 1, 2};
  scene->mRootNode = new aiNode("root");
  scene->mRootNode->mNumMeshes = 1;
  scene->mRootNode->mMeshes = new unsigned[1]{0};
  return scene;
}

/// Moves the root for two seconds and animates the weight of shape number `shape`; there is one.
std::unique_ptr<aiScene> moving_triangle(unsigned shape) {
  auto scene = triangle();
  aiMesh& mesh = *scene->mMeshes[0];
  mesh.mNumAnimMeshes = 1;
  mesh.mAnimMeshes = new aiAnimMesh* [1] { new aiAnimMesh };
  mesh.mAnimMeshes[0]->mNumVertices = 3;
  mesh.mAnimMeshes[0]->mVertices = new aiVector3D[3]{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  auto* const weights = new aiMeshMorphAnim;
  weights->mName = "root";
  weights->mNumKeys = 1;
  weights->mKeys = new aiMeshMorphKey[1];
  weights->mKeys[0].mNumValuesAndWeights = 2;
  weights->mKeys[0].mValues = new unsigned[2]{0, shape};
  weights->mKeys[0].mWeights = new double[2]{0.5, 0.25};
  auto* const animation = new aiAnimation;
  animation->mDuration = 2;
  animation->mTicksPerSecond = 1;
  animation->mNumMorphMeshChannels = 1;
  animation->mMorphMeshChannels = new aiMeshMorphAnim* [1] { weights };
  scene->mNumAnimations = 1;
  scene->mAnimations = new aiAnimation* [1] { animation };
  return scene;
}

Result<AnimatedScene> convert(const aiScene& source, std::string_view importer_name,
                              const ImportOptions& options = {}) {
  auto file = file_scene_from_assimp(source, importer_name);
  if (!file) return file.error();
  return scene_from_file(*std::move(file), options);
}

std::string error_of(const Result<AnimatedScene>& result) {
  return result ? "" : result.error().message;
}

TEST(Convert, RefusesVerticesWithoutPositions) {
  const auto scene = triangle();
  delete[] scene->mMeshes[0]->mVertices;
  scene->mMeshes[0]->mVertices = nullptr;
  EXPECT_NE(error_of(convert(*scene, "")).find("3 vertices and no positions"), std::string::npos);
}

TEST(Convert, AnInvalidFbxUnitIsUnknown) {
  for (const double centimeters : {kInf, kNaN, -1.0, 0.0}) {
    const auto scene = triangle();
    scene->mMetaData = new aiMetadata;
    scene->mMetaData->Add("UnitScaleFactor", centimeters);
    const auto converted = convert(*scene, "Autodesk FBX Importer", {{}, 0.5});
    ASSERT_TRUE(converted) << error_of(converted);
    EXPECT_EQ(converted->scene.meters_per_unit, 0.5);
    EXPECT_EQ(converted->scene.nodes[0].parent_from_local, kIdentity) << centimeters;
  }
}

TEST(Convert, RefusesATransformThatAUnitConversionMakesInfinite) {
  const auto scene = triangle();
  scene->mRootNode->mTransformation.a1 = 1e20f;
  const ImportOptions tiny{{}, 1e-300};
  EXPECT_NE(error_of(convert(*scene, "Collada Importer", tiny)).find("node 'root'"),
            std::string::npos);
  EXPECT_FALSE(convert(*scene, "Collada Importer", tiny));
  EXPECT_TRUE(convert(*scene, "Collada Importer", {{}, 1e-200}));
}

TEST(Convert, RefusesAnInfiniteDuration) {
  for (const double duration : {kInf, kNaN}) {
    const auto scene = moving_triangle(0);
    scene->mAnimations[0]->mDuration = duration;
    EXPECT_NE(error_of(convert(*scene, "")).find("lasts"), std::string::npos);
  }
  const auto scene = moving_triangle(0);
  scene->mAnimations[0]->mTicksPerSecond = 1e-310;
  EXPECT_FALSE(convert(*scene, ""));
}

TEST(Convert, RefusesABoneThatIsNotFinite) {
  for (const double bad : {kInf, kNaN}) {
    const auto scene = triangle();
    aiMesh& mesh = *scene->mMeshes[0];
    mesh.mNumBones = 1;
    mesh.mBones = new aiBone* [1] { new aiBone };
    mesh.mBones[0]->mName = "root";
    mesh.mBones[0]->mOffsetMatrix.a1 = static_cast<float>(bad);
    EXPECT_NE(error_of(convert(*scene, "")).find("bone 0"), std::string::npos) << bad;
  }
}

TEST(Convert, RefusesAWeightThatIsNotFinite) {
  const auto scene = moving_triangle(0);
  scene->mMeshes[0]->mAnimMeshes[0]->mWeight = static_cast<float>(kNaN);
  EXPECT_NE(error_of(convert(*scene, "")).find("weight"), std::string::npos);
}

TEST(Convert, WeightsOfMissingShapesMoveNothing) {
  const auto scene = moving_triangle(4000000000U);
  const auto animated = convert(*scene, "");
  ASSERT_TRUE(animated) << error_of(animated);
  const auto& keys = animated->animations.at(0).deformations.at(0).weights.keys;
  EXPECT_EQ(keys.at(0).value, std::vector<double>{0.5});
}

}  // namespace
}  // namespace sightline::client::importer
