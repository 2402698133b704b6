// Reads of the client's own writes, and of older revisions.
#include "client/types.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::calls {
namespace {

using tests::kScene;

class ConsistencyTest : public tests::LiveClient {
 protected:
  ConsistencyTest() {
    EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(1), {}));
    SetTransforms set{{2}, {kIdentity}};
    set.parent_from_local[0][11] = -3;
    const auto applied = client_.apply(kScene, std::vector<Update>{set});
    EXPECT_TRUE(applied);
    moved_ = *applied;
  }

  // t of a ray from 5 down onto the sheet, which is at 1, and at -2 after it is moved.
  double t_at(const Consistency& consistency, bool by_stream) {
    const tests::DownwardRays ray(1, 1);
    std::vector<double> t(1);
    const CastOptions options{.consistency = consistency};
    const auto cast = by_stream ? client_.cast_stream(kScene, ray.columns(), {.t = t}, options)
                                : client_.cast(kScene, ray.columns(), {.t = t}, options);
    EXPECT_TRUE(cast) << cast.error().message;
    if (cast) {
      EXPECT_FALSE(cast->token.empty());
    }
    return t[0];
  }

  Applied moved_;
};

TEST_F(ConsistencyTest, ReadsAtATokenAndAtARevision) {
  EXPECT_EQ(client_.get_scene(kScene)->token, moved_.token);
  for (const bool by_stream : {false, true}) {
    EXPECT_EQ(t_at({}, by_stream), 7);
    EXPECT_EQ(t_at({.at_least = moved_.token}, by_stream), 7);
    EXPECT_EQ(t_at({.exact_revision = 1}, by_stream), 4);
    EXPECT_EQ(t_at({.exact_revision = 2}, by_stream), 7);
  }
  const std::vector<std::uint64_t> id{2};
  EXPECT_EQ((*client_.get_nodes(kScene, id, {.exact_revision = 1}))[0].parent_from_local[11], 0);
  EXPECT_EQ((*client_.get_nodes(kScene, id))[0].parent_from_local[11], -3);
}

TEST_F(ConsistencyTest, AnUnknownRevisionIsAnError) {
  const tests::DownwardRays ray(1, 1);
  std::vector<double> t(1);
  const auto code_of = [&](const Consistency& consistency) {
    return client_.cast(kScene, ray.columns(), {.t = t}, {.consistency = consistency}).error().code;
  };
  EXPECT_EQ(code_of({.exact_revision = 99}), Code::kOutOfRange);
  EXPECT_EQ(code_of({.at_least = "no token"}), Code::kInvalidArgument);
}

}  // namespace
}  // namespace sightline::client::calls
