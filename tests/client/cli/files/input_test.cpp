// Reading files by lines and as a whole.
#include "client/cli/files/input.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>
#include <thread>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::files {
namespace {

using tests::TempDir;

TEST(Input, ReadsLinesWithAndWithoutAFinalNewline) {
  const TempDir dir;
  auto input = Input::open(dir.write("lines", "one\r\n\ntwo"));
  ASSERT_TRUE(input);
  std::string all;
  std::string_view line;
  for (auto more = input->next_line(line); more && *more; more = input->next_line(line)) {
    all.append("[").append(line).append("]");
  }
  EXPECT_EQ(all, "[one][][two]");
}

TEST(Input, ALineWithoutEndIsAnError) {
  auto input = Input::open("/dev/zero");
  ASSERT_TRUE(input);
  std::string_view line;
  const auto more = input->next_line(line);
  ASSERT_FALSE(more);
  EXPECT_NE(more.error().message.find("a line is longer"), std::string::npos);
}

TEST(Input, PeekConsumesNothing) {
  const TempDir dir;
  auto input = Input::open(dir.write("short", "abc"));
  ASSERT_TRUE(input);
  EXPECT_EQ(*input->peek(2), "ab");
  EXPECT_EQ(*input->peek(10), "abc");
  const auto whole = input->whole();
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->size(), 3U);
}

TEST(Input, PipesAreReadToTheirEnd) {
  const TempDir dir;
  const std::string path = dir.path("pipe");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const std::string content(1 << 20, 'x');
  std::thread writer([&] { (void)dir.write("pipe", content); });
  auto input = Input::open(path);
  ASSERT_TRUE(input);
  EXPECT_EQ(input->peek(6)->size(), 6U);
  const auto whole = input->whole();
  writer.join();
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->size(), content.size());
}

TEST(Input, ReportsAnUnreadableFile) {
  const TempDir dir;
  EXPECT_EQ(Input::open(dir.path("none")).error().message,
            dir.path("none") + ": No such file or directory");
  EXPECT_EQ(Input::open(dir.path("")).error().message, dir.path("") + ": is a directory");
}

}  // namespace
}  // namespace sightline::client::cli::files
