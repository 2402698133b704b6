// Rays as JSON, one a line.
#include "client/cli/files/json_rays.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::files {
namespace {

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

RayRow json_row(const std::string& line) {
  RayRow row{};
  const Status good = parse_json_row(line, row);
  EXPECT_TRUE(good) << good.error().message;
  return row;
}

std::string json_fault(const std::string& line) {
  RayRow row{};
  const Status good = parse_json_row(line, row);
  return good ? "none" : good.error().message;
}

TEST(JsonRays, AreListsOrObjects) {
  EXPECT_EQ(json_row("[1, 2, 3, 4, 5, 6]"), (RayRow{1, 2, 3, 4, 5, 6, 0, kNoEnd}));
  EXPECT_EQ(json_row("[1, 2, 3, 4, 5, 6, 7, 8]"), (RayRow{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(json_row(R"({"direction": [4, 5, 6], "origin": [1, 2, 3], "tmin": 0.5})"),
            (RayRow{1, 2, 3, 4, 5, 6, 0.5, kNoEnd}));
  EXPECT_EQ(json_row(R"({"ox":1,"oy":2,"oz":3,"dx":4,"dy":5,"dz":6,"tmax":"inf"})"),
            (RayRow{1, 2, 3, 4, 5, 6, 0, kNoEnd}));
}

TEST(JsonRays, FaultsAreNamed) {
  EXPECT_EQ(json_fault("[1, 2, 3]"), "a list of 3, a ray has 6 or 8 numbers");
  EXPECT_EQ(json_fault(R"([1, 2, 3, 4, 5, "up"])"), "the list holds \"up\", which is no number");
  EXPECT_EQ(json_fault(R"({"origin": [1, 2, 3]})"), "'dx' is missing");
  EXPECT_EQ(json_fault(R"({"origin": [1, 2]})"), "origin is not 3 numbers");
  EXPECT_EQ(json_fault(R"({"start": [1, 2, 3]})"),
            "key 'start' is none of origin direction ox oy oz dx dy dz tmin tmax");
  EXPECT_EQ(json_fault(R"({"tmin": null})"), "tmin is null, not a number");
  EXPECT_EQ(json_fault("{"), "neither a list nor an object in JSON");
  EXPECT_EQ(json_fault("7"), "neither a list nor an object in JSON");
}

TEST(JsonRays, ErrorsNameFileAndLine) {
  const tests::TempDir dir;
  auto input = Input::open(dir.write("r.ndjson", "\n[1,2,3,4,5,6]\n\n[1]\n"));
  ASSERT_TRUE(input);
  JsonRays rays(*std::move(input));
  RayRow row{};
  EXPECT_TRUE(*rays.next(row));
  const auto wrong = rays.next(row);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("r.ndjson:4: a list of 1"), std::string::npos);
}

}  // namespace
}  // namespace sightline::client::cli::files
