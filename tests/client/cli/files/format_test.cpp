// Suffixes of files of rays and hits.
#include "client/cli/files/format.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::client::cli::files {
namespace {

TEST(Format, IsKnownByTheSuffixInEitherCase) {
  EXPECT_EQ(*format_of("a/b.csv"), Format::kCsv);
  EXPECT_EQ(*format_of("b.TXT"), Format::kCsv);
  EXPECT_EQ(*format_of("b.jsonl"), Format::kNdjson);
  EXPECT_EQ(*format_of("b.npy"), Format::kNpy);
  EXPECT_EQ(*format_of("b.NPZ"), Format::kNpz);
  EXPECT_EQ(*format_of("b.ply"), Format::kPly);
  EXPECT_FALSE(format_of("no_suffix")->has_value());
}

TEST(Format, AnotherSuffixIsRefusedWithThoseThatAreKnown) {
  const auto wrong = format_of("rays.xyz");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message,
            "rays.xyz: .xyz is no suffix of rays or hits: .csv .txt .ndjson .jsonl .npy .npz .ply "
            "are");
}

}  // namespace
}  // namespace sightline::client::cli::files
