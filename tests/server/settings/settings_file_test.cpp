// The settings of a TOML file, each with its line.
#include "server/settings/settings_file.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/server/support/temporary_file.h"

namespace sightline::server::settings {
namespace {

using tests::TemporaryFile;

TEST(SettingsFile, ReadsKeysInTablesWithTheirLines) {
  const TemporaryFile file(
      "# a comment\n"
      "listen = \"127.0.0.1:1\"  # another\n"
      "\n"
      "  threads=3\n"
      "[quota]\n"
      "rays-per-second = 5\n"
      "[[quota.principal]]\n"
      "name = 'a b, c'\n"
      "[[quota.principal]]\n"
      "name = \"d\"\n"
      "insecure = true");
  const auto read = read_settings(file.path());
  ASSERT_TRUE(read) << read.error().message;
  const auto& settings = read->settings;
  ASSERT_EQ(settings.size(), 6u);
  EXPECT_EQ(settings[0].key, "listen");
  EXPECT_EQ(settings[0].value, "127.0.0.1:1");
  EXPECT_EQ(settings[0].line, 2u);
  EXPECT_EQ(settings[0].table, "");
  EXPECT_EQ(settings[1].key, "threads");
  EXPECT_EQ(settings[1].value, "3");
  EXPECT_EQ(settings[1].line, 4u);
  EXPECT_EQ(settings[2].table, "quota");
  EXPECT_EQ(settings[3].table, "quota.principal");
  EXPECT_EQ(settings[3].value, "a b, c");
  EXPECT_EQ(settings[3].header, 7u);
  EXPECT_EQ(settings[4].value, "d");
  EXPECT_EQ(settings[4].header, 9u);
  EXPECT_EQ(settings[5].value, "true");
  EXPECT_EQ(settings[5].line, 11u);
  ASSERT_EQ(read->headers.size(), 3u);
  EXPECT_EQ(read->headers[0].table, "quota");
  EXPECT_EQ(read->headers[0].line, 5u);
  EXPECT_EQ(read->headers[2].table, "quota.principal");
  EXPECT_EQ(read->headers[2].line, 9u);
}

TEST(SettingsFile, NamesTheLineOfAMistake) {
  for (const std::string bad : {"threads",          "threads =",   "= 3",         "threads = 3 4",
                                "a = [1, 2]",       "a = \"b",     "a = \"b\" c", "a = \"b\\n\"",
                                "a = \"b\\u0000\"", "a = 4G",      "a = full",    "a = 1979-05-27",
                                "a = [{b = 1}]",    "a = {b = 1}", "[quota",      "[]",
                                "listen = \"x\"",   "[one]",       "a b",         "{}"}) {
    const TemporaryFile file("listen = \"y\"\n[one]\nlisten = \"x\"\n" + bad + "\n");
    const auto read = read_settings(file.path());
    ASSERT_FALSE(read) << bad;
    EXPECT_EQ(read.error().code, Code::kInvalidArgument) << bad;
    EXPECT_TRUE(read.error().message.starts_with(file.path() + ":4: ")) << read.error().message;
  }
}

TEST(SettingsFile, ValuesAreThoseOfToml) {
  const TemporaryFile file(
      "a = \"b#c\"\nb = \"x\\\"y\"\nc = 1_000\nd = 0x10\ne = 3.5\nf = -3\ng = '\\'\n"
      "h = \"\\u00e4\"\n");
  const auto read = read_settings(file.path());
  ASSERT_TRUE(read) << read.error().message;
  std::vector<std::string> values;
  for (const Setting& setting : read->settings) values.push_back(setting.value);
  EXPECT_EQ(values,
            (std::vector<std::string>{"b#c", "x\"y", "1000", "16", "3.5", "-3", "\\", "ä"}));
}

TEST(SettingsFile, ALargeFileIsRefused) {
  const TemporaryFile file("#" + std::string(std::size_t{1} << 20, 'x'));
  const auto read = read_settings(file.path());
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("more than 1048576 bytes"), std::string::npos);
}

TEST(SettingsFile, NamesAFileThatCannotBeRead) {
  for (const std::string path : {"/nowhere/settings.toml", "/tmp"}) {
    const auto read = read_settings(path);
    ASSERT_FALSE(read) << path;
    EXPECT_NE(read.error().message.find(path), std::string::npos) << read.error().message;
  }
}

TEST(SettingsFile, AnEmptyFileSetsNothing) {
  const TemporaryFile file("");
  const auto read = read_settings(file.path());
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->settings.empty());
}

}  // namespace
}  // namespace sightline::server::settings
