// Sizes in bytes, as people write them.
#include "server/settings/byte_size.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace sightline::server::settings {
namespace {

using Size = std::pair<std::string_view, std::uint64_t>;

TEST(ByteSize, IsANumberWithOrWithoutAUnit) {
  for (const auto& [text, bytes] : {Size{"1", 1},
                                    Size{"7B", 7},
                                    Size{"64k", 65'536},
                                    Size{"64K", 65'536},
                                    Size{"64KiB", 65'536},
                                    Size{"64kB", 64'000},
                                    Size{"64KB", 64'000},
                                    Size{"512M", 536'870'912},
                                    Size{"512m", 536'870'912},
                                    Size{"512MiB", 536'870'912},
                                    Size{"512MB", 512'000'000},
                                    Size{"4G", 4'294'967'296},
                                    Size{"4g", 4'294'967'296},
                                    Size{"4GiB", 4'294'967'296},
                                    Size{"4GB", 4'000'000'000},
                                    Size{"2T", 2'199'023'255'552},
                                    Size{"2TiB", 2'199'023'255'552},
                                    Size{"2TB", 2'000'000'000'000},
                                    Size{"007k", 7'168},
                                    Size{"18446744073709551615", 18'446'744'073'709'551'615u},
                                    Size{"16777215T", 16'777'215u * (std::uint64_t{1} << 40)}}) {
    const auto size = parse_byte_size(text, 1);
    ASSERT_TRUE(size) << text << ": " << size.error().message;
    EXPECT_EQ(*size, bytes) << text;
  }
}

TEST(ByteSize, RefusesWhatIsNone) {
  for (const std::string_view text : {"",
                                      "G",
                                      "-1",
                                      "+1",
                                      "1.5G",
                                      "1e9",
                                      "0x10",
                                      "4 G",
                                      " 4G",
                                      "4G ",
                                      "4GG",
                                      "4Gi",
                                      "4Gb",
                                      "4gb",
                                      "4mB",
                                      "4gib",
                                      "4kiB",
                                      "4kib",
                                      "4Kb",
                                      "4KIB",
                                      "4E",
                                      "4P",
                                      "4b",
                                      "4BiB",
                                      "4iB",
                                      "1,000",
                                      "18446744073709551616",
                                      "16777216T",
                                      "18446744073709551615k",
                                      "inf",
                                      "4\xc2\xb5"}) {
    const auto size = parse_byte_size(text, 0);
    ASSERT_FALSE(size) << text << " is " << *size;
    EXPECT_EQ(size.error().code, Code::kInvalidArgument);
  }
  EXPECT_FALSE(parse_byte_size(std::string_view("4G\0", 3), 0));
}

TEST(ByteSize, AnErrorHasTheTextAndTheLimits) {
  const auto size = parse_byte_size("0G", 1);
  ASSERT_FALSE(size);
  EXPECT_TRUE(size.error().message.starts_with(
      "\"0G\" is not a size from 1 to 18446744073709551615 bytes: "))
      << size.error().message;
  EXPECT_TRUE(parse_byte_size("0G", 0));
}

}  // namespace
}  // namespace sightline::server::settings
