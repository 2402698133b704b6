// The bound on prefetches, and their end.
#include "server/exec/prefetch_calls.h"

#include <gtest/gtest.h>

#include "server/scenes/memory_scene_store.h"

namespace sightline::server::exec {
namespace {

class PrefetchCallsTest : public testing::Test {
 protected:
  scenes::MemorySceneStore scenes_;
  Admission admission_{{}};
  Compute compute_{1};
  CallRegistry waits_{1, "reads", "TOO_MANY_WAITING"};
  queries::CastServices services_{.scenes = scenes_,
                                  .compute = compute_,
                                  .admission = admission_,
                                  .all_hits_admission = admission_,
                                  .waiting = {compute_, admission_, waits_}};
};

TEST_F(PrefetchCallsTest, LetsInSoManyAtATime) {
  PrefetchCalls calls(2);
  queries::PrefetchJob a(services_), b(services_), c(services_);
  EXPECT_TRUE(calls.enter(a));
  EXPECT_TRUE(calls.enter(b));
  const Status refused = calls.enter(c);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kResourceExhausted);
  EXPECT_NE(refused.error().message.find("2 prefetches, the limit is 2"), std::string::npos);
  EXPECT_TRUE(calls.leave(a));
  EXPECT_TRUE(calls.enter(c));
}

TEST_F(PrefetchCallsTest, StoppingEndsThoseInWorkAndLetsNoOtherIn) {
  ASSERT_TRUE(scenes_.create({.name = "projects/p/scenes/s"}));
  v1::PrefetchRequest request;
  request.set_scene("projects/p/scenes/s");
  PrefetchCalls calls(2);
  queries::PrefetchJob a(services_), b(services_);
  ASSERT_TRUE(a.open(request));
  EXPECT_TRUE(calls.enter(a));
  calls.stop();
  const Status built = a.run();
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().code, Code::kCancelled);
  EXPECT_EQ(calls.leave(a).error().code, Code::kUnavailable);
  EXPECT_EQ(calls.enter(b).error().code, Code::kUnavailable);
}

}  // namespace
}  // namespace sightline::server::exec
