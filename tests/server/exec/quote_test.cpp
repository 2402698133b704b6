// Callers' text in messages and logs.
#include "server/exec/quote.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

TEST(Quote, ShowsPrintableText) { EXPECT_EQ(quote("a b"), "\"a b\""); }

TEST(Quote, CannotForgeALogLine) {
  EXPECT_EQ(quote("a\nevent=x"), "\"a?event=x\"");
  EXPECT_EQ(quote("say \"hi\" \\"), R"("say \"hi\" \\")");
  EXPECT_EQ(quote(std::string_view("\0\x7f\xff", 3)), "\"???\"");
}

TEST(Quote, CutsLongText) {
  EXPECT_EQ(quote(std::string(1000, 'x')),
            "\"" + std::string(kMaxQuoted, 'x') + "\"... (1000 bytes)");
}

}  // namespace
}  // namespace sightline::server::exec
