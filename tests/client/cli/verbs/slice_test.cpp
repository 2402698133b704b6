// sightline slice: its numbers by formula, its picture, and what it refuses.
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "tests/client/support/boxes.h"
#include "tests/client/support/run_program.h"

namespace sightline::tests {
namespace {

using nlohmann::json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A ball around the origin, whose faces are within 0.4 % of the sphere of this radius.
constexpr double kRadius = 10;

std::string ball_obj() {
  constexpr int kRings = 48, kParts = 96;
  client::importer::ImportedMesh ball;
  ball.name = "ball";
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int part = 0; part < kParts; ++part) {
      const double polar = std::numbers::pi * ring / kRings;
      const double turn = 2 * std::numbers::pi * part / kParts;
      const double around = ring == kRings ? 0 : kRadius * std::sin(polar);
      ball.vertices.push_back({static_cast<float>(around * std::cos(turn)),
                               static_cast<float>(around * std::sin(turn)),
                               static_cast<float>(kRadius * std::cos(polar))});
    }
  }
  const auto at = [](int ring, int part) {
    return static_cast<std::uint32_t>(ring * kParts + part % kParts);
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int part = 0; part < kParts; ++part) {
      ball.faces.push_back({at(ring, part), at(ring + 1, part), at(ring + 1, part + 1)});
      ball.faces.push_back({at(ring, part), at(ring + 1, part + 1), at(ring, part + 1)});
    }
  }
  return obj_of({ball});
}

struct Png {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  int channel(std::uint32_t x, std::uint32_t y, int k) const {
    return rgb[3 * (std::size_t{y} * width + x) + static_cast<std::size_t>(k)];
  }
};

Png decode(const std::string& bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0);
  image.format = PNG_FORMAT_RGB;
  Png png{image.width, image.height, std::vector<std::uint8_t>(PNG_IMAGE_SIZE(image))};
  EXPECT_NE(png_image_finish_read(&image, nullptr, png.rgb.data(), 0, nullptr), 0);
  return png;
}

class SliceVerb : public LiveProgram {
 protected:
  SliceVerb() {
    EXPECT_EQ(run_program({"scene", "import", "ball", dir_.write("ball.obj", ball_obj())}).exit, 0);
  }

  ProgramOutcome slice(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"slice", "ball", "--out", dir_.path("slice.png")};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }

  std::vector<double> numbers(const std::string& file) const {
    const std::string bytes = dir_.read(file);
    const std::string data = bytes.substr(bytes.find('\n') + 1);
    std::vector<double> values(data.size() / sizeof(double));
    std::memcpy(values.data(), data.data(), values.size() * sizeof(double));
    return values;
  }
};

TEST_F(SliceVerb, NumbersAreTheDistancesOfABall) {
  const std::string npy = dir_.path("slice.npy");
  const auto made = slice({"--z", "3", "--size", "80x60", "--npy", npy, "--json"});
  ASSERT_EQ(made.exit, 0) << made.err;
  const json report = json::parse(made.out);
  EXPECT_EQ(report["points"], 80 * 60);
  EXPECT_EQ(report["npy"], npy);
  EXPECT_NE(dir_.read("slice.npy").find("'shape': (60, 80)"), std::string::npos);
  const auto distances = numbers("slice.npy");
  ASSERT_EQ(distances.size(), 80U * 60);
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const double right = (static_cast<double>(i % 80) + 0.5) / 80;
    const double below = (static_cast<double>(i / 80) + 0.5) / 60;
    const double x = report["origin"][0].get<double>() + right * report["across"][0].get<double>();
    const double y = report["origin"][1].get<double>() + below * report["down"][1].get<double>();
    const double expected = std::sqrt(x * x + y * y + 9) - kRadius;
    ASSERT_NEAR(distances[i], expected, 0.04) << i;
  }
}

TEST_F(SliceVerb, ThePictureShowsSidesAndSurface) {
  // 100 pixels are 40 long.
  ASSERT_EQ(slice({"--origin", "-20,20,0", "--across", "40,0,0", "--down", "0,-40,0", "--size",
                   "100x100", "--no-scale", "--iso", "5"})
                .exit,
            0);
  const Png png = decode(dir_.read("slice.png"));
  ASSERT_EQ(png.width, 100U);
  ASSERT_EQ(png.height, 100U);
  const auto darkness = [&](std::uint32_t x) {
    return 765 - png.channel(x, 50, 0) - png.channel(x, 50, 1) - png.channel(x, 50, 2);
  };
  EXPECT_GT(png.channel(56, 50, 2), png.channel(56, 50, 0) + 30) << "blue inside";
  EXPECT_GT(png.channel(97, 50, 0), png.channel(97, 50, 2) + 30) << "red outside";
  EXPECT_GT(darkness(75) + darkness(74), 1300) << "black at the radius, 25 pixels from the middle";
  EXPECT_GT(darkness(87) + darkness(88), darkness(83) + darkness(92) + 100) << "a line at 5";
}

TEST_F(SliceVerb, AScaleStandsBesideTheSlice) {
  ASSERT_EQ(slice({"--y", "0", "--size", "160x100"}).exit, 0);
  const Png with = decode(dir_.read("slice.png"));
  EXPECT_GT(with.width, 160U);
  EXPECT_EQ(with.height, 100U);
  ASSERT_EQ(slice({"--y", "0", "--size", "160x100", "--no-scale"}).exit, 0);
  const Png without = decode(dir_.read("slice.png"));
  ASSERT_EQ(without.width, 160U);
  for (std::uint32_t y = 0; y < 100; y += 9) {
    for (std::uint32_t x = 0; x < 160; x += 7)
      ASSERT_EQ(with.channel(x, y, 1), without.channel(x, y, 1)) << x << ' ' << y;
  }
}

TEST_F(SliceVerb, WithoutSidesDistancesHaveNoSign) {
  const std::string npy = dir_.path("slice.npy");
  ASSERT_EQ(slice({"--x", "0", "--size", "30x30", "--npy", npy, "--unsigned"}).exit, 0);
  for (const double distance : numbers("slice.npy")) ASSERT_GE(distance, 0);
  ASSERT_EQ(slice({"--x", "0", "--size", "30x30", "--npy", npy, "--side", "normal"}).exit, 0);
  const auto distances = numbers("slice.npy");
  EXPECT_LT(distances[15 * 30 + 15], -9);
  EXPECT_GT(distances[0], 0);
}

TEST_F(SliceVerb, WindingShowsTheUnionOfWhatOverlaps) {
  const std::string obj =
      obj_of({mesh_of({{0, 0, 0}, {2, 2, 2}}), mesh_of({{1, 1, 1}, {3, 3, 3}})});
  ASSERT_EQ(run_program({"scene", "import", "boxes", dir_.write("b.obj", obj)}).exit, 0);
  const std::string npy = dir_.path("one.npy");
  const auto at_overlap = [&](const char* rule) {
    EXPECT_EQ(run_program({"slice", "boxes", "--out", dir_.path("b.png"), "--origin", "1,1,1.5",
                           "--across", "1,0,0", "--down", "0,1,0", "--size", "1x1", "--npy", npy,
                           "--side", rule})
                  .exit,
              0);
    return numbers("one.npy")[0];
  };
  EXPECT_EQ(at_overlap("parity"), 0.5);
  EXPECT_EQ(at_overlap("winding"), -0.5);
}

TEST_F(SliceVerb, NodesThatDoNotCountAreLeftOut) {
  std::vector boxes{mesh_of({{0, 0, 0}, {2, 2, 2}}), mesh_of({{5, 0, 0}, {6, 2, 2}})};
  boxes[0].name = "left";
  boxes[1].name = "right";
  ASSERT_EQ(run_program({"scene", "import", "boxes", dir_.write("b.obj", obj_of(boxes))}).exit, 0);
  const std::string npy = dir_.path("one.npy");
  const auto at_gap = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"slice", "boxes", "--out", dir_.path("b.png"), "--npy", npy};
    for (const char* word :
         {"--origin", "2.5,0.5,1", "--across", "1,0,0", "--down", "0,1,0", "--size", "1x1"})
      words.emplace_back(word);
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run_program(words).exit, 0);
    return numbers("one.npy")[0];
  };
  EXPECT_EQ(at_gap({}), 1);
  EXPECT_EQ(at_gap({"--exclude", "left"}), 2);
  EXPECT_EQ(at_gap({"--under", "right"}), 2);
  EXPECT_EQ(at_gap({"--exclude", "left", "--exclude", "right"}), kInfinity);
  EXPECT_EQ(at_gap({"--exclude", "left", "right"}), kInfinity);
  EXPECT_EQ(slice({"--z", "0", "--under", "bal"}).exit, 3);
  EXPECT_EQ(slice({"--z", "0", "--exclude", "-1"}).exit, 2);
}

// By 63 rays a point, the points of a message take far longer than a millisecond.
TEST_F(SliceVerb, PointsForWhichThereIsNoTimeAreCounted) {
  const std::string npy = dir_.path("slice.npy");
  const std::vector<std::string> words{
      "--z", "0", "--size", "600x600", "--side-rays", "63", "--time-budget", "1", "--npy", npy};
  auto with_json = words;
  with_json.emplace_back("--json");
  const auto made = slice(with_json);
  EXPECT_EQ(made.exit, 5);
  EXPECT_NE(made.err.find(" of 360,000 points have no answer"), std::string::npos) << made.err;
  const json report = json::parse(made.out);
  const auto distances = numbers("slice.npy");
  EXPECT_EQ(report["unanswered"], std::count(distances.begin(), distances.end(), -kInfinity));
  EXPECT_GT(report["unanswered"], 0);
  const auto text = slice(words);
  EXPECT_EQ(text.exit, 5);
  EXPECT_NE(text.out.find(" unanswered, colours to "), std::string::npos) << text.out;
  EXPECT_EQ(slice({"--z", "0", "--time-budget", "0"}).exit, 2);
}

TEST_F(SliceVerb, LinesThatAreTooDenseAreLeftOut) {
  const auto made = slice({"--z", "0", "--size", "100x100", "--iso", "0.01"});
  EXPECT_EQ(made.exit, 0);
  EXPECT_NE(made.err.find("too dense"), std::string::npos) << made.err;
  EXPECT_EQ(slice({"--z", "0", "--size", "100x100", "--iso", "5"}).err, "");
}

TEST_F(SliceVerb, AnEmptySceneHasAPicture) {
  ASSERT_TRUE(client_.create_scene("projects/default/scenes/none"));
  EXPECT_EQ(run_program({"slice", "none", "--z", "0", "--out", dir_.path("n.png")}).exit, 0);
}

TEST_F(SliceVerb, WhatCannotBeDrawnIsAUsageError) {
  struct Case {
    std::vector<std::string> more;
    const char* text;
  };
  for (const Case& wrong :
       {Case{{}, "one of --x, --y and --z says where the slice is"},
        Case{{"--z", "0", "--x", "0"}, "one of --x, --y and --z"},
        Case{{"--z", "0", "--origin", "0,0,0"}, "one of --x, --y and --z"},
        Case{{"--origin", "0,0,0", "--across", "1,0,0"}, "--origin, --across and --down together"},
        Case{{"--origin", "0,0,0", "--across", "1,0,0", "--down", "2,0,0"}, "no area"},
        Case{{"--z", "inf"}, "--z: 'inf' is not a number"},
        Case{{"--z", "0", "--iso", "0"}, "--iso: '0' is not a number above 0"},
        Case{{"--z", "0", "--range", "-1"}, "--range: '-1' is not a number above 0"},
        Case{{"--z", "0", "--size", "9000x1"}, "--size: '9000x1' is not WxH"},
        Case{{"--z", "0", "--side-rays", "2"}, "--side-rays: '2' is not an odd number"},
        Case{{"--z", "0", "--side", "normal", "--side-rays", "3"}, "--side-rays: 3 with --side"},
        Case{{"--z", "0", "--unsigned", "--side", "parity"}, "--unsigned"},
        Case{{"--z", "0", "--npy", "a.csv"}, "--npy: 'a.csv' does not end with .npy"}}) {
    const auto refused = slice(wrong.more);
    EXPECT_EQ(refused.exit, 2) << refused.err;
    EXPECT_NE(refused.err.find(wrong.text), std::string::npos) << refused.err;
  }
  EXPECT_EQ(run_program({"slice", "ball", "--z", "0", "--out", "p.jpg"}).exit, 2);
  EXPECT_EQ(run_program({"slice", "none", "--z", "0", "--out", dir_.path("p.png")}).exit, 3);
  EXPECT_EQ(dir_.names(), "ball.obj");
}

}  // namespace
}  // namespace sightline::tests
