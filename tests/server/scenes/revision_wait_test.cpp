// Reads that wait for a revision, and the events that end the wait.
#include "server/scenes/revision_wait.h"

#include <gtest/gtest.h>

#include <future>
#include <string>

namespace sightline::server::scenes {
namespace {

class RevisionWaitTest : public testing::Test {
 protected:
  using Answer = std::future<Result<RevisionWait::SnapshotPointer>>;

  /// Waits for the revision that is this many beyond the newest.
  Answer read(RevisionWait& wait, std::uint64_t ahead, std::chrono::hours time = kLong,
              std::size_t bytes = 1) {
    v1::Consistency consistency;
    consistency.set_at_least(scene_->token(scene_->snapshot()->revision() + ahead).text());
    auto result = std::make_shared<std::promise<Result<RevisionWait::SnapshotPointer>>>();
    wait.read(scene_, consistency, std::chrono::system_clock::now() + time, bytes,
              {"address", std::to_string(++connections_)},
              [result](auto answer) { result->set_value(std::move(answer)); });
    return result->get_future();
  }
  std::shared_ptr<RevisionWait> wait() {
    return std::make_shared<RevisionWait>(compute_, admission_, waits_);
  }
  void publish() { ASSERT_TRUE(scene_->apply({}, compute_)); }

  static constexpr std::chrono::hours kLong{1};
  int connections_ = 0;
  exec::Admission admission_{{.rays = 10, .bytes = 1000}};
  exec::CallRegistry waits_{{.limit = 2,
                             .when_full = "{} reads wait",
                             .full_reason = "TOO_MANY_WAITING",
                             .shared = false}};
  exec::MemoryAccount memory_{std::uint64_t{1} << 30};
  const std::shared_ptr<StoredScene> scene_ =
      std::make_shared<StoredScene>(SceneInfo{.name = "projects/p/scenes/s"}, memory_);
  exec::Compute compute_{1};
};

TEST_F(RevisionWaitTest, IsAnsweredWhenItsRevisionIsPublished) {
  const auto first = wait(), second = wait();
  auto one = read(*first, 1), two = read(*second, 2);
  EXPECT_EQ(admission_.in_flight().bytes, 2u);
  publish();
  EXPECT_EQ((*one.get())->revision(), 1u);
  publish();
  EXPECT_EQ((*two.get())->revision(), 2u);
  EXPECT_EQ(admission_.in_flight().bytes, 0u);
}

TEST_F(RevisionWaitTest, DoesNotWaitForAPublishedRevision) {
  const auto ready = wait();
  auto answer = read(*ready, 0);
  EXPECT_EQ(answer.wait_for(std::chrono::seconds(0)), std::future_status::ready);
  EXPECT_TRUE(answer.get());
}

TEST_F(RevisionWaitTest, EndsWithTheServer) {
  const auto waiting = wait(), late = wait();
  auto answer = read(*waiting, 1);
  waits_.stop();
  EXPECT_EQ(answer.get().error().reason, "STOPPING");
  EXPECT_EQ(read(*late, 1).get().error().code, Code::kUnavailable);
}

TEST_F(RevisionWaitTest, EndsWithTheScene) {
  const auto waiting = wait();
  auto answer = read(*waiting, 1);
  scene_->remove();
  EXPECT_EQ(answer.get().error().code, Code::kNotFound);
}

TEST_F(RevisionWaitTest, EndsWhenCancelledEvenBeforeItBegins) {
  const auto waiting = wait(), before = wait();
  auto answer = read(*waiting, 1);
  waiting->cancel();
  waiting->cancel();
  EXPECT_EQ(answer.get().error().code, Code::kCancelled);
  before->cancel();
  EXPECT_EQ(read(*before, 1).get().error().code, Code::kCancelled);
}

TEST_F(RevisionWaitTest, EndsWithTheDeadline) {
  const auto waiting = wait();
  const auto error = read(*waiting, 1, -kLong).get().error();
  EXPECT_EQ(error.code, Code::kUnavailable);
  EXPECT_EQ(error.reason, "REVISION_NOT_THERE");
}

TEST_F(RevisionWaitTest, LimitsTheNumberAndTheBytesOfWaitingReads) {
  const auto a = wait(), b = wait(), c = wait(), d = wait();
  auto first = read(*a, 1), second = read(*b, 1);
  EXPECT_EQ(read(*c, 1).get().error().reason, "TOO_MANY_WAITING");
  EXPECT_EQ(admission_.in_flight().bytes, 2u) << "a refused read is not counted";
  EXPECT_EQ(read(*d, 1, kLong, 5000).get().error().code, Code::kResourceExhausted);
  publish();
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(second.get());
}

}  // namespace
}  // namespace sightline::server::scenes
