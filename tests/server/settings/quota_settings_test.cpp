// The quotas in the file of settings.
#include "server/settings/quota_settings.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/server/support/temporary_file.h"

namespace sightline::server::settings {
namespace {

using exec::QuotaLimits;
using tests::TemporaryFile;

TEST(QuotaSettings, NamedPrincipalsInheritWhatTheyDoNotSet) {
  const TemporaryFile file(
      "threads = 2\n"
      "[quota]\n"
      "rays-per-second = 1000\n"
      "concurrent-work = 4\n"
      "[[quota.principal]]\n"
      "name = \"nightly\"\n"
      "rays-per-second = 0\n"
      "bytes-stored = 7\n"
      "[[quota.principal]]\n"
      "bytes-per-second = 9\n"
      "name = \"ipv4:10.0.0.7\"\n");
  const auto read = read_settings(file.path());
  ASSERT_TRUE(read) << read.error().message;
  const auto quotas = read_quotas(*read);
  ASSERT_TRUE(quotas) << quotas.error().message;
  EXPECT_EQ(quotas->others, (QuotaLimits{1000, 0, 4, 0}));
  ASSERT_EQ(quotas->principals.size(), 2u);
  EXPECT_EQ(quotas->principals.at("nightly"), (QuotaLimits{0, 0, 4, 7}));
  EXPECT_EQ(quotas->principals.at("ipv4:10.0.0.7"), (QuotaLimits{1000, 9, 4, 0}));
  EXPECT_TRUE(quotas->limits());
  const std::string printed = print_quotas(*read);
  EXPECT_NE(printed.find("bytes-stored = 7  # file " + file.path() + ":8\n"), std::string::npos)
      << printed;
  const TemporaryFile again(printed);
  const auto reread = read_settings(again.path());
  ASSERT_TRUE(reread) << reread.error().message;
  EXPECT_EQ(read_quotas(*reread)->principals, quotas->principals);
}

TEST(QuotaSettings, WithoutTablesNothingIsLimited) {
  const auto quotas = read_quotas({});
  ASSERT_TRUE(quotas);
  EXPECT_FALSE(quotas->limits());
}

TEST(QuotaSettings, NameTheLineOfAMistake) {
  struct Case {
    std::string text;
    int line;
  };
  for (const auto& [text, line] :
       {Case{"[quota]\nrays = 3", 2},
        {"[quota]\nrays-per-second = -3", 2},
        {"[quota]\nrays-per-second = 3.5", 2},
        {"[quota]\nname = \"a\"", 2},
        {"[quotas]\nrays-per-second = 3", 1},
        {"threads = 2\n[quotas]", 2},
        {"[quota]\n[quota.principals]", 2},
        {"[quota.principal]\nname = \"a\"", 1},
        {"[[quota]]\nbytes-stored = 3", 1},
        {"[[quota.principal]]", 1},
        {"[[quota.principal]]\n[[quota.principal]]\nname = \"a\"", 1},
        {"[[quota.principal]]\nbytes-stored = 3", 1},
        {"[[quota.principal]]\nname = \"a\"\n[[quota.principal]]\nname = \"a\"", 4}}) {
    const TemporaryFile file(text);
    const auto read = read_settings(file.path());
    ASSERT_TRUE(read) << text;
    const auto quotas = read_quotas(*read);
    ASSERT_FALSE(quotas) << text;
    EXPECT_TRUE(quotas.error().message.starts_with(file.path() + ":" + std::to_string(line) + ": "))
        << quotas.error().message;
  }
}

}  // namespace
}  // namespace sightline::server::settings
