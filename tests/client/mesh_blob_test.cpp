// The bytes of a mesh and their digest.
#include "client/mesh_blob.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace sightline::client {
namespace {

const std::vector<Vertex> kVertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
const std::vector<Face> kFaces{{0, 1, 2}, {kNoVertex, kNoVertex, kNoVertex}};

std::string bytes_of(const MeshBlob& blob) {
  std::string bytes(blob.size(), '\0');
  blob.copy(0, std::as_writable_bytes(std::span(bytes)));
  return bytes;
}

TEST(MeshBlob, IsHeaderThenPositionsThenIndices) {
  const std::string bytes = bytes_of({kVertices, kFaces});
  ASSERT_EQ(bytes.size(), 24U + 36U + 24U);
  EXPECT_EQ(bytes.substr(0, 8), std::string("SLM1\0\0\0\0", 8));
  EXPECT_EQ(bytes.substr(8, 8), std::string("\3\0\0\0\0\0\0\0", 8));
  EXPECT_EQ(bytes.substr(16, 8), std::string("\2\0\0\0\0\0\0\0", 8));
  float x = 0;
  std::memcpy(&x, bytes.data() + 24 + 12, 4);
  EXPECT_EQ(x, 1.0F);
  EXPECT_EQ(bytes.substr(72), std::string(12, '\xff'));
}

TEST(MeshBlob, AnyPartEqualsThatPartOfTheWhole) {
  const MeshBlob blob(kVertices, kFaces);
  const std::string whole = bytes_of(blob);
  for (std::size_t first = 0; first <= whole.size(); ++first) {
    for (std::size_t n = 0; first + n <= whole.size(); n += 5) {
      std::string part(n, '\0');
      blob.copy(first, std::as_writable_bytes(std::span(part)));
      ASSERT_EQ(part, whole.substr(first, n)) << first << " " << n;
    }
  }
}

TEST(MeshBlob, AnEmptyMeshHasAHeader) { EXPECT_EQ(MeshBlob({}, {}).size(), 24U); }

TEST(MeshBlob, TheDigestIsTheSha256OfTheBytesAndTheirCount) {
  // printf 'SLM1\0\0\0\0...' | sha256sum, of the 24 bytes of an empty mesh
  EXPECT_EQ(MeshBlob({}, {}).digest(),
            "sha256:81dd3a1c45cf24d263579221ac7bad0ab8bd8df5521a3f1f6c73ce059aec5715/24");
  EXPECT_NE(MeshBlob(kVertices, {}).digest(), MeshBlob({}, kFaces).digest());
}

}  // namespace
}  // namespace sightline::client
