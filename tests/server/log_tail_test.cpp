// The last lines of the log.
#include "server/log_tail.h"

#include <gtest/gtest.h>

namespace sightline::server {
namespace {

TEST(LogTailTest, GivesLinesAfterANumber) {
  LogTail tail;
  EXPECT_TRUE(tail.after(0).lines.empty());
  tail.add("one\n");
  tail.add("two");
  const LogTail::Lines all = tail.after(0);
  EXPECT_EQ(all.first, 1u);
  EXPECT_EQ(all.lines, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(tail.after(1).first, 2u);
  EXPECT_EQ(tail.after(1).lines, std::vector<std::string>{"two"});
  EXPECT_TRUE(tail.after(2).lines.empty());
  EXPECT_TRUE(tail.after(~std::uint64_t{0}).lines.empty());
}

TEST(LogTailTest, KeepsTheLastLinesAlone) {
  LogTail tail;
  for (std::size_t i = 1; i <= LogTail::kLines + 10; ++i) tail.add(std::to_string(i));
  const LogTail::Lines kept = tail.after(3);
  EXPECT_EQ(kept.first, 11u);
  EXPECT_EQ(kept.lines.size(), LogTail::kLines);
  EXPECT_EQ(kept.lines.front(), "11");
}

TEST(LogTailTest, CutsLongLinesAndShowsPlainTextAlone) {
  LogTail tail;
  tail.add(std::string(LogTail::kMaxLine + 1, 'a'));
  tail.add("\x1b[31m\xff");
  EXPECT_EQ(tail.after(0).lines[0].size(), LogTail::kMaxLine);
  EXPECT_EQ(tail.after(0).lines[1], "?[31m?");
}

}  // namespace
}  // namespace sightline::server
