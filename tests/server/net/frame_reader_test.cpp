#include "server/net/frame_reader.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/server/support/frames.h"

namespace sightline::tests {
namespace {

using server::net::FrameHead;
using server::net::FrameReader;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

struct Seen {
  FrameHead head;
  std::ptrdiff_t begin;
};

std::vector<Seen> read_pieces(const std::vector<std::string_view>& pieces, std::size_t skipped) {
  FrameReader reader(skipped);
  std::vector<Seen> all;
  std::ptrdiff_t before = 0;
  for (const std::string_view piece : pieces) {
    reader.read(bytes_of(piece), [&](const FrameHead& head, std::ptrdiff_t begin) {
      all.push_back({head, before + begin});
      return true;
    });
    before += static_cast<std::ptrdiff_t>(piece.size());
  }
  return all;
}

std::string every_type() {
  std::string all(kPreface);
  for (std::uint8_t type = 0; type < 12; ++type)
    all += frame(type, type, 1U << type, std::string(type % 5, 'p'));
  return all + reset(77, 8) + frame(0xff, 0xff, 0xffff'ffff);
}

TEST(FrameReader, FindsEveryTypeHoweverTheBytesAreSplit) {
  const std::string all = every_type();
  const auto whole = read_pieces({all}, kPreface.size());
  ASSERT_EQ(whole.size(), 14U);
  EXPECT_EQ(whole[4].head.type, 4);
  EXPECT_EQ(whole[4].head.flags, 4);
  EXPECT_EQ(whole[4].head.stream, 16U);
  EXPECT_EQ(whole[4].head.size, 4U);
  EXPECT_EQ(whole[12].head.error, 8U);
  EXPECT_EQ(whole[13].head.stream, 0x7fff'ffffU);
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    const std::string_view text = all;
    const auto parts = read_pieces({text.substr(0, cut), text.substr(cut)}, kPreface.size());
    ASSERT_EQ(parts.size(), whole.size()) << cut;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      EXPECT_EQ(parts[i].begin, whole[i].begin) << cut;
      EXPECT_EQ(parts[i].head.type, whole[i].head.type) << cut;
      EXPECT_EQ(parts[i].head.stream, whole[i].head.stream) << cut;
      EXPECT_EQ(parts[i].head.error, whole[i].head.error) << cut;
    }
  }
}

TEST(FrameReader, TakesSingleBytes) {
  const std::string all = every_type();
  std::vector<std::string_view> bytes;
  for (std::size_t i = 0; i < all.size(); ++i) bytes.push_back(std::string_view(all).substr(i, 1));
  EXPECT_EQ(read_pieces(bytes, kPreface.size()).size(), 14U);
}

TEST(FrameReader, AResetOfAnotherSizeHasNoCode) {
  const auto seen = read_pieces({frame(FrameHead::kResetStream, 0, 1, "12345"), reset(3, 5)}, 0);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].head.error, 0U);
  EXPECT_EQ(seen[1].head.error, 5U);
}

}  // namespace
}  // namespace sightline::tests
