// Tracks between their keys and outside them.
#include "client/importer/animation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sightline::client::importer {
namespace {

Track<Point> ramp() { return {{{1, {0, 0, 0}}, {2, {2, 4, 6}}, {4, {2, 4, 10}}}}; }

Quaternion about_x(double degrees) {
  const double half = degrees * std::numbers::pi / 360;
  return {std::cos(half), std::sin(half), 0, 0};
}

TEST(KeyFrames, AreInterpolatedLinearly) {
  EXPECT_EQ(sample(ramp(), 1), (Point{0, 0, 0}));
  EXPECT_EQ(sample(ramp(), 1.5), (Point{1, 2, 3}));
  EXPECT_EQ(sample(ramp(), 2), (Point{2, 4, 6}));
  EXPECT_EQ(sample(ramp(), 3), (Point{2, 4, 8}));
  EXPECT_EQ(sample(ramp(), 4), (Point{2, 4, 10}));
}

TEST(KeyFrames, OutsideThemTheTrackDecides) {
  Track<Point> track = ramp();
  EXPECT_EQ(sample(track, 0), (Point{0, 0, 0}));
  EXPECT_EQ(sample(track, 9), (Point{2, 4, 10}));
  track.before = track.after = Beyond::kExtrapolate;
  EXPECT_EQ(sample(track, 0), (Point{-2, -4, -6}));
  EXPECT_EQ(sample(track, 5), (Point{2, 4, 12}));
  track.before = track.after = Beyond::kRepeat;
  EXPECT_EQ(sample(track, 4.5), (Point{1, 2, 3}));
  EXPECT_EQ(sample(track, -1), (Point{2, 4, 6}));
  EXPECT_EQ(sample(track, 0.5), (Point{2, 4, 9}));
}

TEST(KeyFrames, OneKeyIsConstant) {
  for (const Beyond beyond : {Beyond::kHold, Beyond::kExtrapolate, Beyond::kRepeat}) {
    const Track<Point> track{{{3, {1, 2, 3}}}, beyond, beyond};
    for (const double t : {-5.0, 3.0, 7.0}) EXPECT_EQ(sample(track, t), (Point{1, 2, 3}));
  }
}

TEST(KeyFrames, TwoKeysAtOneTimeAreAStep) {
  const Track<Point> track{{{0, {0, 0, 0}}, {1, {0, 0, 0}}, {1, {5, 5, 5}}, {2, {5, 5, 5}}}};
  EXPECT_EQ(sample(track, 0.999), (Point{0, 0, 0}));
  EXPECT_EQ(sample(track, 1), (Point{5, 5, 5}));
}

TEST(KeyFrames, RotationsTakeTheShorterArcAtConstantSpeed) {
  Quaternion far = about_x(80);
  for (double& x : far) x = -x;  // The same rotation
  const Track<Quaternion> track{{{0, about_x(0)}, {1, far}}};
  for (const double part : {0.0, 0.1, 0.25, 0.5, 0.9, 1.0}) {
    const Quaternion expected = about_x(80 * part);
    const Quaternion actual = sample(track, part);
    double cosine = 0;
    for (std::size_t k = 0; k < 4; ++k) cosine += actual[k] * expected[k];
    EXPECT_NEAR(std::abs(cosine), 1, 1e-12) << part;
  }
}

TEST(KeyFrames, NearlyEqualRotationsStayOfUnitLength) {
  const Track<Quaternion> track{{{0, about_x(10)}, {1, about_x(10 + 1e-9)}}};
  const Quaternion actual = sample(track, 0.5);
  double square = 0;
  for (const double x : actual) square += x * x;
  EXPECT_NEAR(square, 1, 1e-15);
}

TEST(Steps, KeepTheEarlierKey) {
  Track<Point> track = ramp();
  track.interpolation = Interpolation::kStep;
  EXPECT_EQ(sample(track, 0), (Point{0, 0, 0}));
  EXPECT_EQ(sample(track, 1), (Point{0, 0, 0}));
  EXPECT_EQ(sample(track, 1.999), (Point{0, 0, 0}));
  EXPECT_EQ(sample(track, 2), (Point{2, 4, 6}));
  EXPECT_EQ(sample(track, 3.999), (Point{2, 4, 6}));
  EXPECT_EQ(sample(track, 4), (Point{2, 4, 10}));
  EXPECT_EQ(sample(track, 9), (Point{2, 4, 10}));
}

TEST(Steps, AreForRotationsAndWeights) {
  Track<Quaternion> turn{{{0, about_x(0)}, {1, about_x(80)}}};
  turn.interpolation = Interpolation::kStep;
  EXPECT_EQ(sample(turn, 0.99), about_x(0));
  EXPECT_EQ(sample(turn, 1), about_x(80));
  Track<std::vector<double>> weights{{{0, {1, 2}}, {1, {3, 4}}}};
  weights.interpolation = Interpolation::kStep;
  EXPECT_EQ(sample(weights, 0.5), (std::vector<double>{1, 2}));
}

// Values are those of the polynomials 2t^3 - 3t^2 + 1, t^3 - 2t^2 + t, 3t^2 - 2t^3 and t^3 - t^2.
TEST(CubicSplines, FollowTheirTangents) {
  Track<Point> track;
  track.interpolation = Interpolation::kCubic;
  track.keys = {{1, {0, 1, 0}}, {3, {0, 0, 8}}};
  track.tangents = {{{9, 9, 9}, {32, 0, 0}}, {{-16, 0, 0}, {9, 9, 9}}};
  EXPECT_EQ(sample(track, 1), (Point{0, 1, 0}));
  EXPECT_EQ(sample(track, 3), (Point{0, 0, 8}));
  // A quarter of the way: 27/32, 9/64, 5/32 and -3/64; the tangents count for 2 s.
  EXPECT_EQ(sample(track, 1.5), (Point{2 * (32 * 9 + 16 * 3) / 64.0, 27 / 32.0, 8 * 5 / 32.0}));
  EXPECT_EQ(sample(track, 2), (Point{2 * (32 + 16) / 8.0, 0.5, 4}));
}

TEST(CubicSplines, HoldOutsideTheirKeys) {
  Track<Point> track;
  track.interpolation = Interpolation::kCubic;
  track.keys = {{1, {1, 1, 1}}, {2, {2, 2, 2}}};
  track.tangents = {{{5, 5, 5}, {5, 5, 5}}, {{5, 5, 5}, {5, 5, 5}}};
  EXPECT_EQ(sample(track, -1), (Point{1, 1, 1}));
  EXPECT_EQ(sample(track, 7), (Point{2, 2, 2}));
}

TEST(CubicSplines, OfRotationsHaveUnitLength) {
  Track<Quaternion> track;
  track.interpolation = Interpolation::kCubic;
  track.keys = {{0, {2, 0, 0, 0}}, {1, {0, 0, 2, 0}}, {2, {0, 0, -2, 0}}};
  track.tangents.resize(3);
  EXPECT_EQ(sample(track, 0), (Quaternion{1, 0, 0, 0}));
  EXPECT_EQ(sample(track, -1), (Quaternion{1, 0, 0, 0}));
  const Quaternion half = sample(track, 0.5);
  EXPECT_NEAR(half[0], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(half[2], std::sqrt(0.5), 1e-15);
  EXPECT_EQ(sample(track, 1.5), (Quaternion{1, 0, 0, 0})) << "zeros are no rotation";
}

TEST(CubicSplines, AreForWeights) {
  Track<std::vector<double>> track;
  track.interpolation = Interpolation::kCubic;
  track.keys = {{0, {0, 4}}, {2, {8, 0}}};
  track.tangents = {{{}, {4}}, {{0, 8}, {}}};
  EXPECT_EQ(sample(track, 1), (std::vector<double>{4 + 2 * 4 / 8.0, 2 - 2 * 8 / 8.0}));
}

TEST(KeyFrames, MissingWeightsAreZero) {
  const Track<std::vector<double>> track{{{0, {1}}, {1, {0, 1}}}};
  EXPECT_EQ(sample(track, 0.25), (std::vector<double>{0.75, 0.25}));
}

}  // namespace
}  // namespace sightline::client::importer
