// Rays that the server makes against the same rays sent to it.
#include "client/ray_generator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client {
namespace {

using tests::kScene;

constexpr std::uint32_t kCopies = 7;

class RayGenerators : public tests::LiveClient {
 protected:
  RayGenerators() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(kCopies), {})); }
};

/// More rays than a message has, over all sheets.
RayGenerator picture() {
  Pinhole pinhole{.eye = {30, 0.5, 40}, .corner = {-35, 3, -40}, .across = {75, 0, 0}};
  pinhole.down = {0, -6, 0};
  pinhole.width = 301;
  pinhole.height = 30;
  pinhole.samples = {{0.3, 0.6}, {0.8, 0.1}};
  pinhole.tiled = true;
  return {.rays = pinhole};
}

RayGenerator scan() {
  SphericalScan scan{.origin = {30.5, 0.5, 1.5}};
  scan.azimuth = {-std::numbers::pi, std::numbers::pi};
  scan.elevation = {-std::numbers::pi / 2, std::numbers::pi / 2};
  scan.columns = 200;
  scan.rows = 100;
  return {.rays = scan};
}

RayGenerator pairs(bool listed) {
  VisibilityPairs pairs;
  for (std::uint32_t i = 0; i < 150; ++i) {
    pairs.from.push_back({0.4 * i, 0.5, 3});
    pairs.to.push_back({0.41 * i, 0.25, i % 2 == 0 ? -1.0 : 2.0});
    if (listed) pairs.pairs.push_back({i, 149 - i});
  }
  RayGenerator generator{.rays = pairs};
  generator.tmin = 1e-6;
  return generator;
}

struct Answers {
  explicit Answers(std::size_t n) : t(n), node(n), primitive(n), normal(3 * n) {}
  HitColumns spans() { return {.t = t, .node = node, .primitive = primitive, .normal = normal}; }
  bool operator==(const Answers&) const = default;

  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> normal;
};

TEST_F(RayGenerators, TheServerMakesTheRaysThatTheClientMakes) {
  for (const RayGenerator& generator : {picture(), scan(), pairs(false), pairs(true)}) {
    const auto rays = make_rays(generator);
    ASSERT_TRUE(rays) << rays.error().message;
    const std::size_t n = rays->tmin.size();
    Answers sent(n), generated(n);
    const auto expected = client_.cast_stream(kScene, rays->columns(), sent.spans());
    const auto report = client_.cast_stream(kScene, generator, generated.spans());
    ASSERT_TRUE(expected && report) << report.error().message;
    EXPECT_TRUE(sent == generated);
    EXPECT_EQ(report->rays, n);
    EXPECT_EQ(report->hits, expected->hits);
    EXPECT_EQ(report->invalid, expected->invalid);
    EXPECT_GT(report->hits, 0U);
    EXPECT_LT(report->hits, n);
  }
}

TEST_F(RayGenerators, BitsTellWhichPointsSeeEachOther) {
  const RayGenerator generator = pairs(false);
  const auto rays = make_rays(generator);
  ASSERT_TRUE(rays);
  const std::size_t n = rays->tmin.size();
  std::vector<std::uint8_t> hit(n), bits(bits_bytes(n));
  ASSERT_TRUE(
      client_.cast_stream(kScene, rays->columns(), {.hit = hit}, {.kind = QueryKind::kAny}));
  ASSERT_TRUE(
      client_.cast_stream(kScene, generator, {.hit_bits = bits}, {.kind = QueryKind::kAny}));
  for (std::size_t i = 0; i < n; ++i) ASSERT_EQ((bits[i / 8] >> (i % 8)) & 1, hit[i]) << i;
}

TEST_F(RayGenerators, ARangeIsAPartOfTheWhole) {
  RayGenerator some = scan();
  Answers whole(20000), part(9000);
  ASSERT_TRUE(client_.cast_stream(kScene, some, whole.spans()));
  some.first = 555;
  some.count = 9000;
  ASSERT_TRUE(client_.cast_stream(kScene, some, part.spans()));
  for (std::size_t i = 0; i < 9000; ++i) ASSERT_EQ(part.t[i], whole.t[555 + i]) << i;
}

TEST_F(RayGenerators, PrefetchBuildsWhatTheyEnter) {
  const auto report = client_.prefetch_rays(kScene, picture());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->rays_done, 301U * 30 * 2);
  EXPECT_GT(report->cells_expanded, 0U);
  Answers answers(301 * 30 * 2);
  const auto cast = client_.cast_stream(kScene, picture(), answers.spans());
  ASSERT_TRUE(cast);
  EXPECT_EQ(cast->cells_expanded, 0U);
}

TEST_F(RayGenerators, AreRefusedBeforeTheyAreSent) {
  RayGenerator bad = scan();
  std::get<SphericalScan>(bad.rays).azimuth[0] = std::nan("");
  EXPECT_EQ(make_rays(bad).error().reason, "BAD_ANGLE");
  Answers answers(20000);
  EXPECT_EQ(client_.cast_stream(kScene, bad, answers.spans()).error().reason, "BAD_ANGLE");
  EXPECT_EQ(client_.prefetch_rays(kScene, bad).error().reason, "BAD_ANGLE");
  answers.t.pop_back();
  EXPECT_EQ(client_.cast_stream(kScene, scan(), answers.spans()).error().code,
            Code::kInvalidArgument);
}

}  // namespace
}  // namespace sightline::client
