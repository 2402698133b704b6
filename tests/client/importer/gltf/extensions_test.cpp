// Which files are refused for their version or for what they require.
#include "client/importer/gltf/extensions.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/client/importer/gltf/read_file.h"

namespace sightline::client::importer::gltf {
namespace {

using tests::GltfFile;
using tests::read_made;
using tests::refusal_of;
using tests::triangle_under_root;

GltfFile file_with(const char* list, const std::vector<std::string>& names) {
  GltfFile file = triangle_under_root();
  file.json["extensionsUsed"] = names;
  file.json[list] = names;
  return file;
}

TEST(Extensions, ThatAreRequiredAndUnknownAreRefusedByName) {
  for (const std::string name :
       {"FOO_tessellation", "KHR_gaussian_splatting", "CESIUM_RTC", "MPEG_mesh_linking"}) {
    const std::string said = refusal_of(file_with("extensionsRequired", {name}));
    EXPECT_NE(said.find(name), std::string::npos) << said;
  }
  const std::string said = refusal_of(
      file_with("extensionsRequired", {"ZOO_b", "KHR_materials_unlit", "ACME_a", "ZOO_b"}));
  EXPECT_NE(said.find("extensions ACME_a, ZOO_b, which are"), std::string::npos) << said;
}

TEST(Extensions, ThatCannotChangeGeometryMayBeRequired) {
  for (const std::string name :
       {"KHR_texture_transform", "KHR_materials_variants", "KHR_texture_basisu", "EXT_texture_webp",
        "KHR_lights_punctual", "KHR_xmp_json_ld", "KHR_mesh_quantization",
        "EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "KHR_draco_mesh_compression"}) {
    const auto scene = read_made(file_with("extensionsRequired", {name}));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_TRUE(scene->warnings.empty()) << name;
  }
}

TEST(Extensions, ThatAreOnlyUsedAndUnknownAreWarnedAbout) {
  for (const std::string name : {"FOO_tessellation", "AGI_articulations", "CESIUM_RTC"}) {
    const auto scene = read_made(file_with("extensionsUsed", {name}));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->warnings.size(), 1U);
    EXPECT_EQ(scene->warnings[0].kind, "gltf_extension");
    EXPECT_EQ(scene->warnings[0].first, name);
    EXPECT_NE(scene->warnings[0].message.find(name), std::string::npos);
  }
  EXPECT_TRUE(
      read_made(file_with("extensionsUsed", {"KHR_materials_clearcoat"}))->warnings.empty());
}

std::string refusal_of_version(const std::string& version, const std::string& least = "") {
  GltfFile file = triangle_under_root();
  file.json["asset"] = {{"version", version}};
  if (!least.empty()) file.json["asset"]["minVersion"] = least;
  return refusal_of(file);
}

TEST(Version, MustBe2) {
  EXPECT_EQ(refusal_of_version("2.0"), "");
  EXPECT_EQ(refusal_of_version("2.1"), "");
  EXPECT_EQ(refusal_of_version("2.1", "2.0"), "");
  EXPECT_NE(refusal_of_version("2.1", "2.1").find("minVersion is 2.1"), std::string::npos);
  EXPECT_NE(refusal_of_version("1.0").find("glTF 1.0, which is not read"), std::string::npos);
  EXPECT_NE(refusal_of_version("1.1").find("glTF 1.1"), std::string::npos);
  EXPECT_NE(refusal_of_version("3.0").find("glTF 3.0"), std::string::npos);
  EXPECT_NE(refusal_of_version("two"), "");
  EXPECT_NE(refusal_of_version("2"), "");
  EXPECT_NE(refusal_of(std::string("{}")).find("asset.version"), std::string::npos);
}

}  // namespace
}  // namespace sightline::client::importer::gltf
