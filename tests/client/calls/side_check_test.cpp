// What is refused about sides before it is sent.
#include "client/calls/side_check.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::client::calls {
namespace {

std::string reason_of(const Status& status) { return status ? "" : status.error().reason; }

std::string message_of(const Status& status) { return status ? "" : status.error().message; }

constexpr HitFields kSigned{.signed_distance = true};
constexpr HitFields kVotes{.votes = true};

TEST(SideCheck, AcceptsWhatAServerAnswers) {
  EXPECT_TRUE(check_sides({}, {.t = true}));
  EXPECT_TRUE(check_sides({}, kSigned));
  EXPECT_TRUE(check_sides({.side_rule = SideRule::kWinding, .side_rays = 63}, kVotes));
  EXPECT_TRUE(check_sides({.side_rays = 1}, {.inside = true}));
  EXPECT_TRUE(check_sides({.side_rule = SideRule::kNormal, .side_rays = 1}, kSigned));
}

TEST(SideCheck, NamesTheValueAndTheLimit) {
  EXPECT_EQ(message_of(check_sides({.side_rays = 4}, kSigned)),
            "side_rays is 4, but must be odd and at most 63");
  EXPECT_EQ(reason_of(check_sides({.side_rays = 4}, kSigned)), "SIDE_RAYS");
  EXPECT_EQ(reason_of(check_sides({.side_rays = 65}, kSigned)), "SIDE_RAYS");
  EXPECT_EQ(message_of(check_sides({.side_rule = SideRule::kNormal, .side_rays = 3}, kSigned)),
            "side_rays is 3, but kNormal casts no rays");
}

TEST(SideCheck, RulesAndFieldsGoTogether) {
  EXPECT_EQ(reason_of(check_sides({.side_rule = SideRule::kParity}, {.t = true})),
            "SIDE_NOT_ASKED");
  EXPECT_EQ(reason_of(check_sides({.side_rays = 3}, {})), "SIDE_NOT_ASKED");
  EXPECT_EQ(reason_of(check_sides({.side_rule = SideRule::kNormal}, kVotes)), "FIELD_NOT_OF_RULE");
  for (const QueryKind kind : {QueryKind::kAny, QueryKind::kCount, QueryKind::kAll})
    EXPECT_EQ(reason_of(check_sides({.kind = kind}, kVotes)), "FIELD_NOT_OF_KIND");
}

TEST(SideCheck, RaysHaveNoSides) {
  EXPECT_TRUE(check_no_sides({}, {.t = true}));
  EXPECT_EQ(reason_of(check_no_sides({}, kSigned)), "FIELD_NOT_OF_KIND");
  EXPECT_EQ(reason_of(check_no_sides({.side_rays = 3}, {.t = true})), "SIDE_NOT_ASKED");
}

TEST(SideCheck, WithoutRowsNothingIsAskedAboutSides) {
  const CastOptions options{.max_hits = 7, .side_rule = SideRule::kNormal, .side_rays = 1};
  EXPECT_TRUE(has_sides(options));
  EXPECT_FALSE(has_sides(without_sides(options)));
  EXPECT_EQ(without_sides(options).max_hits, 7U);
}

}  // namespace
}  // namespace sightline::client::calls
