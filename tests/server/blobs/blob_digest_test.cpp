// Digests of blobs.
#include "server/blobs/blob_digest.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/server/blobs/blob_of.h"

namespace sightline::server::blobs {
namespace {

// The digest of "abc" from FIPS 180-2.
const std::string kAbc =
    "sha256:ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad/3";

TEST(BlobDigest, IsTheSha256OfTheBytes) { EXPECT_EQ(tests::digest_of("abc").text(), kAbc); }

TEST(BlobDigest, ParsesWhatItWrites) {
  const auto parsed = BlobDigest::parse(kAbc);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(*parsed, tests::digest_of("abc"));
  EXPECT_EQ(parsed->text(), kAbc);
}

TEST(BlobDigest, RefusesAllButTheCanonicalForm) {
  std::string upper = kAbc;
  upper[7] = 'B';
  const std::string stem = kAbc.substr(0, kAbc.size() - 1);
  for (const std::string& text :
       {std::string(), upper, stem, stem + "03", stem + "-3", stem + "3 ", stem + "0x3",
        stem + "99999999999999999999", "sha512" + kAbc.substr(6), kAbc.substr(0, 60) + "/3",
        std::string("sha256:/3")}) {
    const auto parsed = BlobDigest::parse(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().code, Code::kInvalidArgument);
  }
}

}  // namespace
}  // namespace sightline::server::blobs
