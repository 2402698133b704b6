// Text from outside, before it goes into a header, a status or a line of the log.
#include "proto/printable.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace sightline::tests {
namespace {

TEST(Printable, IsWhatGrpcTakesInAHeader) {
  for (int byte = 0; byte < 256; ++byte) {
    const std::string text(1, static_cast<char>(byte));
    EXPECT_EQ(is_printable(text), byte >= 0x20 && byte <= 0x7e) << byte;
    EXPECT_EQ(is_visible(text), byte > 0x20 && byte <= 0x7e) << byte;
    EXPECT_TRUE(is_printable(printable(text))) << byte;
    EXPECT_EQ(one_line(text) == text, byte >= 0x20 && byte != 0x7f) << byte;
  }
  EXPECT_TRUE(is_printable(std::string_view()));
  EXPECT_FALSE(is_visible(std::string_view()));
  EXPECT_FALSE(is_visible("a b"));
}

TEST(Printable, ShowsTheRest) {
  EXPECT_EQ(printable(std::string_view("a\0b\xc3\xa9\n", 6)), "a?b???");
  EXPECT_EQ(one_line("a\nb\xc3\xa9"), "a?b\xc3\xa9");
}

}  // namespace
}  // namespace sightline::tests
