// Digests of blobs; mesh blobs, whole and in pieces, right and wrong.
#include "server/blobs/mesh_blob.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "server/exec/heap_trimmer.h"
#include "tests/server/blobs/blob_of.h"
#include "tests/support/scenes.h"

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

using tests::blob_of;
using tests::bytes_of;

Result<std::shared_ptr<const scenegraph::model::Mesh>> read(const std::string& blob,
                                                            std::size_t piece) {
  MeshBlobReader reader(blob.size());
  for (std::size_t at = 0; at < blob.size(); at += piece) {
    const Status taken =
        reader.append(bytes_of(blob).subspan(at, std::min(piece, blob.size() - at)));
    if (!taken) return taken.error();
  }
  return reader.finish();
}

TEST(MeshBlob, ReadsPiecesOfAnySize) {
  const tests::TestMesh cube = tests::cube();
  const std::string blob = blob_of(cube);
  for (const std::size_t piece : {1u, 5u, 12u, 24u, 100u, 100'000u}) {
    const auto mesh = read(blob, piece);
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_TRUE(std::ranges::equal((*mesh)->view().vertices, cube.vertices));
    EXPECT_TRUE(std::ranges::equal((*mesh)->view().faces, cube.faces));
  }
}

TEST(MeshBlob, MayBeEmpty) {
  const auto mesh = read(blob_of({}), 100);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ((*mesh)->faces(), 0u);
}

void expect_bad(const std::string& blob) {
  const auto mesh = read(blob, 1000);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, Code::kInvalidArgument) << mesh.error().message;
}

TEST(MeshBlob, RefusesOtherBytes) {
  expect_bad(std::string(1000, 'x'));
  std::string other = blob_of(tests::cube());
  other[3] = '2';
  expect_bad(other);
}

TEST(MeshBlob, TheCopyNumberIsIgnored) {
  std::string blob = blob_of(tests::cube());
  blob[4] = 1;
  const auto mesh = read(blob, 1000);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ((*mesh)->faces(), 12u);
}

TEST(MeshBlob, RefusesCountsThatDisagreeWithItsSize) {
  const std::string blob = blob_of(tests::cube());
  for (const std::size_t index : {8u, 15u, 16u, 23u}) {
    std::string wrong = blob;
    wrong[index] = static_cast<char>(wrong[index] + 1);
    expect_bad(wrong);
  }
  expect_bad(blob + "x");
  expect_bad(blob.substr(0, blob.size() - 1));
}

TEST(MeshBlob, RefusesCountsWhoseSumWrapsAround) {
  std::string blob = blob_of(tests::cube());
  std::fill(blob.begin() + 8, blob.begin() + 24, '\xff');
  expect_bad(blob);
}

// The allocators of sanitizers keep to rules of their own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(MeshBlob, WhatHasNotArrivedIsNotResident) {
  constexpr int kScratch = 28 << 20;
  ASSERT_EQ(::mallopt(M_MMAP_THRESHOLD, 32 << 20), 1);
  ASSERT_EQ(::mallopt(M_TRIM_THRESHOLD, 64 << 20), 1);
  { const std::vector<char> scratch(kScratch, 'x'); }
  const std::uint64_t before = exec::resident_bytes();
  const std::uint64_t rows = 2'000'000;
  std::string header = blob_of({}).substr(0, 24);
  std::memcpy(&header[8], &rows, sizeof(rows));
  MeshBlobReader reader(header.size() + rows * 12);
  ASSERT_TRUE(reader.append(bytes_of(header)));
  EXPECT_LT(exec::resident_bytes() + rows * 10, before)
      << "nearly all of the scratch is given back";
}
#endif

TEST(MeshBlob, RefusesExtraBytes) {
  const std::string blob = blob_of(tests::cube());
  MeshBlobReader reader(blob.size());
  ASSERT_TRUE(reader.append(bytes_of(blob)));
  EXPECT_FALSE(reader.append(bytes_of("x")));
}

TEST(MeshBlob, RefusesMissingBytes) {
  const std::string blob = blob_of(tests::cube());
  MeshBlobReader reader(blob.size());
  ASSERT_TRUE(reader.append(bytes_of(blob).first(blob.size() - 1)));
  const auto mesh = reader.finish();
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, Code::kInvalidArgument);
}

TEST(MeshBlob, RefusesAnIndexOutOfRange) {
  tests::TestMesh cube = tests::cube();
  cube.faces[3][1] = static_cast<std::uint32_t>(cube.vertices.size());
  expect_bad(blob_of(cube));
}

}  // namespace
}  // namespace sightline::server::blobs
