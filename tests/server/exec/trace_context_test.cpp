// The header traceparent.
#include "server/exec/trace_context.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace sightline::server::exec {
namespace {

constexpr std::string_view kTrace = "4bf92f3577b34da6a3ce929d0e0e4736";
constexpr std::string_view kGood = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

/// The valid header with other text from a place on.
std::string with(std::size_t at, std::string_view text) {
  std::string header(kGood);
  return header.replace(at, text.size(), text);
}

TEST(TraceContext, IsReadFromAValidHeader) {
  EXPECT_EQ(parse_trace_id(kGood), kTrace);
  EXPECT_EQ(parse_trace_id(with(53, "00")), kTrace);
  EXPECT_EQ(parse_trace_id(with(53, "ff")), kTrace) << "unknown flags do no harm";
  EXPECT_EQ(parse_trace_id(" \t" + std::string(kGood) + "\t "), kTrace);
}

TEST(TraceContext, ALaterVersionMayHaveMore) {
  EXPECT_EQ(parse_trace_id(with(0, "01")), kTrace);
  EXPECT_EQ(parse_trace_id(with(0, "cc") + "-what-comes.later"), kTrace);
  EXPECT_EQ(parse_trace_id(with(0, "cc") + "-"), kTrace);
  EXPECT_EQ(parse_trace_id(with(0, "cc") + ".what"), "");
  EXPECT_EQ(parse_trace_id(with(0, "cc") + "0"), "");
}

TEST(TraceContext, AWrongHeaderHasNone) {
  const std::string zeros(32, '0');
  for (const std::string& header : {std::string(),
                                    std::string("00"),
                                    std::string("   "),
                                    std::string(kGood).substr(0, 54),
                                    std::string(kGood) + "-",
                                    std::string(kGood) + "-01",
                                    std::string(kGood) + "0",
                                    with(0, "ff"),
                                    with(0, "0G"),
                                    with(0, "FF"),
                                    with(0, "0A"),
                                    with(3, zeros),
                                    with(36, zeros.substr(0, 16)),
                                    with(3, "4BF9"),
                                    with(36, "00F0"),
                                    with(53, "0G"),
                                    with(53, "0A"),
                                    with(2, "_"),
                                    with(35, "_"),
                                    with(52, "_"),
                                    with(10, " "),
                                    with(10, "\n"),
                                    with(10, std::string_view("\0", 1)),
                                    with(10, "\xc3"),
                                    with(36, "-")})
    EXPECT_EQ(parse_trace_id(header), "") << header;
}

}  // namespace
}  // namespace sightline::server::exec
