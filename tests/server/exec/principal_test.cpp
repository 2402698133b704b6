// What a principal may do, by role and by prefix.
#include "server/exec/principal.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

const Principal kOperator{.name = "operator",
                          .grants = {{Role::kRead, {""}}, {Role::kWrite, {"projects/site/"}}}};

std::string reason_of(const Status& status) { return status ? "" : status.error().reason; }

TEST(Principal, HasTheRolesOfItsGrantsAndThoseBelow) {
  EXPECT_TRUE(kOperator.may(Role::kRead, "projects/a/scenes/b"));
  EXPECT_FALSE(kOperator.may(Role::kWrite, "projects/a/scenes/b"));
  EXPECT_TRUE(kOperator.may(Role::kWrite, "projects/site/scenes/b"));
  EXPECT_FALSE(kOperator.may(Role::kAdmin, "projects/site/scenes/b"));
}

TEST(Principal, ErrorsNameWhatItLacks) {
  EXPECT_TRUE(kOperator.check(Role::kWrite));
  EXPECT_EQ(reason_of(kOperator.check(Role::kAdmin)), "ROLE_MISSING");
  EXPECT_EQ(reason_of(kOperator.check(Role::kWrite, "projects/a/scenes/b")), "ROLE_MISSING");
  const Principal guest{.name = "guest", .grants = {{Role::kAdmin, {"projects/guest/"}}}};
  const Status other = guest.check(Role::kRead, "projects/site/scenes/b");
  EXPECT_EQ(reason_of(other), "SCENE_FORBIDDEN");
  EXPECT_EQ(other.error().code, Code::kPermissionDenied);
}

}  // namespace
}  // namespace sightline::server::exec
