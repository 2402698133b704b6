// The warning about float32 rays far from the origin: the rule and the command.
#include "client/cli/verbs/origin_precision.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <limits>
#include <vector>

#include "client/cli/files/npy.h"
#include "client/cli/program.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::verbs {
namespace {

constexpr std::array<double, 6> kMetre{0, 0, 0, 1, 0, 0};

TEST(OriginPrecision, ComparesTheSpacingWithAMillionthOfTheDiagonal) {
  // Between 8 and 16 floats have a spacing of 2^-20 = 0.95e-6, from 16 on twice that.
  EXPECT_EQ(origin_precision_warning(0, kMetre), "");
  EXPECT_EQ(origin_precision_warning(std::nextafter(16.0f, 0.0f), kMetre), "");
  EXPECT_NE(origin_precision_warning(16, kMetre), "");
  EXPECT_EQ(origin_precision_warning(16, {-1, 0, 0, 1, 0, 0}), "");
  EXPECT_EQ(origin_precision_warning(1e7f, {0, 0, 0, 1e6, 1e6, 0}), "");
}

TEST(OriginPrecision, DependsOnTheSizeOfTheSceneNotOnItsPosition) {
  EXPECT_EQ(origin_precision_warning(1e7f, {1e7, 0, 0, 1e7 + 1, 0, 0}),
            "rays are float32 and begin up to 1e+07 from the origin, where float32 values are 1 "
            "apart; the scene's diagonal is 1: write them as float64");
}

TEST(OriginPrecision, IsCheckedWhileRaysAreRead) {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::vector<float>> batches{{1, -2, 0}, {nan, -inf, -30, 4, 5, 6}, {}};
  float reach = 0;
  std::size_t next = 0;
  const RaySource<float> source = watch_reach(
      [&](const RayColumns<float>& buffer) -> Result<std::size_t> {
        const std::vector<float>& batch = batches[next++];
        std::copy(batch.begin(), batch.end(), buffer.origins.begin());
        return batch.size() / 3;
      },
      reach);
  std::vector<float> origins(12, 99.0f), directions(12);
  const RayColumns<float> buffer{origins, directions};
  EXPECT_EQ(*source(buffer), 1U);
  EXPECT_EQ(reach, 2);
  EXPECT_EQ(*source(buffer), 2U);
  EXPECT_EQ(*source(buffer), 0U);
  EXPECT_EQ(reach, 30);
}

class CoarseCast : public tests::LiveClient {
 protected:
  /// Squares of one unit, far along x.
  void SetUp() override {
    importer::ImportedScene scene = tests::row_of_sheets(1);
    scene.nodes[0].parent_from_local[3] = kFarOut;
    ASSERT_TRUE(upload_scene(client_, tests::kScene, scene, {}));
    ::setenv("SIGHTLINE_ENDPOINT", endpoint().c_str(), 1);
  }
  void TearDown() override { ::unsetenv("SIGHTLINE_ENDPOINT"); }

  template <class Scalar>
  std::string rays(const char* dtype, double x) {
    std::string dict =
        "{'descr': '" + std::string(dtype) + "', 'fortran_order': False, 'shape': (2, 6), }\n";
    std::string file(files::kNpyMagic);
    file += {'\1', '\0', static_cast<char>(dict.size()), '\0'};
    file += dict;
    for (const double value :
         {x + 0.75, 0.25, 5.0, 0.0, 0.0, -1.0, 0.0, 0.0, 5.0, 0.0, 0.0, -1.0}) {
      const auto number = static_cast<Scalar>(value);
      file.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
    return dir_.write("rays.npy", file);
  }

  // The command's output on stderr.
  std::string cast(const std::string& in) {
    const std::string out = dir_.path("hits.npy");
    const std::vector<const char*> arguments{"sightline", "cast",  "test",      "--in",
                                             in.c_str(),  "--out", out.c_str(), "--json"};
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_EQ(cli::run_program(static_cast<int>(arguments.size()), arguments.data()), 0);
    EXPECT_EQ(testing::internal::GetCapturedStdout().find("warning"), std::string::npos);
    return testing::internal::GetCapturedStderr();
  }

  static constexpr double kFarOut = 1e7;
  tests::TempDir dir_;
};

TEST_F(CoarseCast, WarnsOnceOfFarFloat32Rays) {
  const std::string said = cast(rays<float>("<f4", kFarOut));
  const std::size_t first = said.find("rays are float32 and begin up to 1e+07 from the origin");
  EXPECT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find("float32 and begin", first + 20), std::string::npos) << said;
}

TEST_F(CoarseCast, DoesNotWarnOfFarFloat64OrNearFloat32Rays) {
  EXPECT_EQ(cast(rays<double>("<f8", kFarOut)).find("float32"), std::string::npos);
  EXPECT_EQ(cast(rays<float>("<f4", 0)).find("float32"), std::string::npos);
}

}  // namespace
}  // namespace sightline::client::cli::verbs
