// Text in UTF-16, and files that are not.
#include "client/importer/encoding.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace sightline::client::importer {
namespace {

using namespace std::string_literals;

std::string utf16(std::string_view text, bool big_endian, bool marked) {
  std::string bytes;
  if (marked) bytes = big_endian ? "\xfe\xff" : "\xff\xfe";
  for (const char c : text) {
    if (big_endian) bytes += '\0';
    bytes += c;
    if (!big_endian) bytes += '\0';
  }
  return bytes;
}

TEST(Encoding, Utf16IsNamed) {
  for (const bool big_endian : {false, true}) {
    for (const bool marked : {false, true}) {
      for (const char* text : {"v 0 0 0\nv 1 0 0\n", "<?xml version='1.0'?>"}) {
        const Status checked = check_encoding(utf16(text, big_endian, marked));
        ASSERT_FALSE(checked);
        EXPECT_NE(checked.error().message.find("UTF-16"), std::string::npos);
      }
    }
  }
}

TEST(Encoding, OtherFilesPass) {
  EXPECT_TRUE(check_encoding(""));
  EXPECT_TRUE(check_encoding("v 0 0 0\n"));
  EXPECT_TRUE(check_encoding("\xef\xbb\xbfv 0 0 0\n")) << "UTF-8 with a mark";
  EXPECT_TRUE(check_encoding(std::string(84, '\0'))) << "a binary STL file";
  EXPECT_TRUE(check_encoding("glTF\x02\0\0\0"s));
  EXPECT_TRUE(check_encoding("Kaydara FBX Binary  \0\x1a\0"s));
}

}  // namespace
}  // namespace sightline::client::importer
