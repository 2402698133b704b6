// Text of callers in messages and logs.
#include "server/exec/in_quotes.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

TEST(InQuotes, ShowsPrintableText) { EXPECT_EQ(in_quotes("a b"), "\"a b\""); }

TEST(InQuotes, CannotForgeALogLine) {
  EXPECT_EQ(in_quotes("a\nevent=x"), "\"a?event=x\"");
  EXPECT_EQ(in_quotes("say \"hi\" \\"), R"("say \"hi\" \\")");
  EXPECT_EQ(in_quotes(std::string_view("\0\x7f\xff", 3)), "\"???\"");
}

TEST(InQuotes, CutsLongText) {
  EXPECT_EQ(in_quotes(std::string(1000, 'x')),
            "\"" + std::string(kMaxQuoted, 'x') + "\"... (1000 bytes)");
}

}  // namespace
}  // namespace sightline::server::exec
