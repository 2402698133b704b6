// Makes the pages of the admin port, on a thread that may wait.
#include "server/admin/page_thread.h"

#include <gtest/gtest.h>

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
    expected += std::to_string(i % 10);
    ASSERT_TRUE(pages.make(std::to_string(i % 10), [&](const HttpReply& reply) {
      order += reply.body;
      answered.count_down();
    }));
  }
  EXPECT_FALSE(pages.make("", [](const HttpReply&) { ADD_FAILURE(); }));
  may_answer.count_down();
  answered.wait();
  EXPECT_EQ(order, expected);
}

}  // namespace
}  // namespace sightline::server::admin
