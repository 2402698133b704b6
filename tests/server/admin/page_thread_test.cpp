// Makes the pages of the admin port, on a thread that may wait.
#include "server/admin/page_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <latch>
#include <string>

namespace sightline::server::admin {
namespace {

TEST(PageThread, MakesPagesInOrderAndRefusesTooMany) {
  std::latch may_answer{1};
  std::latch answered{PageThread::kMaxWaiting};
  std::string order, expected;
  PageThread pages([&](auto path) {
    may_answer.wait();
    return HttpReply{.body = std::string(path)};
  });
  for (std::size_t i = 0; i < PageThread::kMaxWaiting; ++i) {
    expected += std::to_string(i);
    ASSERT_TRUE(pages.make(std::to_string(i), Urgency::kPage, [&](const HttpReply& reply) {
      order += reply.body;
      answered.count_down();
    }));
  }
  EXPECT_FALSE(pages.make("", Urgency::kPage, [](const HttpReply&) { ADD_FAILURE(); }));
  may_answer.count_down();
  answered.wait();
  EXPECT_EQ(order, expected);
}

TEST(PageThread, MakesAPageOnceForAllWhoWaitForIt) {
  constexpr std::size_t kAsked = PageThread::kMaxWaiting - 1;
  std::latch begun{1}, may_answer{1}, answered{kAsked + 1};
  std::atomic<int> made{0};
  PageThread pages([&](auto) {
    if (++made == 1) begun.count_down();
    may_answer.wait();
    return HttpReply{.body = std::to_string(made)};
  });
  std::string replies;
  const auto done = [&](const HttpReply& reply) {
    replies += reply.body;
    answered.count_down();
  };
  ASSERT_TRUE(pages.make("/metrics", Urgency::kPage, done));
  begun.wait();
  for (std::size_t i = 0; i < kAsked; ++i)
    ASSERT_TRUE(pages.make("/metrics", Urgency::kPage, done));
  may_answer.count_down();
  answered.wait();
  EXPECT_EQ(made, 2) << "who asks while a page is made gets the next one";
  EXPECT_EQ(replies, "1" + std::string(kAsked, '2'));
}

TEST(PageThread, MakesProbesFirst) {
  std::latch begun{1}, may_answer{1}, answered{PageThread::kMaxWaiting + 1};
  std::string order;
  PageThread pages([&](auto path) {
    if (path == "first") begun.count_down();
    may_answer.wait();
    return HttpReply{.body = std::string(path)};
  });
  const auto done = [&](const HttpReply& reply) {
    order += reply.body + " ";
    answered.count_down();
  };
  ASSERT_TRUE(pages.make("first", Urgency::kPage, done));
  begun.wait();
  for (std::size_t i = 1; i < PageThread::kMaxWaiting; ++i)
    ASSERT_TRUE(pages.make("/metrics", Urgency::kPage, done));
  ASSERT_FALSE(pages.make("/metrics", Urgency::kPage, done));
  ASSERT_TRUE(pages.make("/readyz", Urgency::kProbe, done)) << "pages leave it room";
  may_answer.count_down();
  answered.wait();
  EXPECT_TRUE(order.starts_with("first /readyz /metrics ")) << order;
}

}  // namespace
}  // namespace sightline::server::admin
