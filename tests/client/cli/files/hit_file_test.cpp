// Hits written to files.
#include "client/cli/files/hit_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "client/cli/files/npy.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::files {
namespace {

using tests::TempDir;

const std::vector<double> kT{1.5, std::numeric_limits<double>::infinity(), std::nan("")};
const std::vector<std::uint64_t> kNode{7, 0, 0};
const std::vector<std::uint32_t> kPrimitive{3, 0, 0};
const std::vector<float> kUv{0.25F, 0.5F, 0, 0, 0, 0};
const std::vector<float> kNormal{0, 0, 1, 0, 0, 0, 0, 0, 0};
const std::vector<std::uint8_t> kHit{1, 0, 2};
const std::vector<std::uint32_t> kWork{5 | kSawDeferred, 2, 0};
const HitView kHits{kT, kNode, kPrimitive, kUv, kNormal, kHit, kWork};

void write(const std::string& path, std::vector<HitColumn> columns,
           std::optional<std::uint64_t> rows) {
  auto file = HitFile::open(path, std::move(columns), {.rows = rows});
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_TRUE(file->write(kHits, 3));
  ASSERT_TRUE(file->commit());
}

template <class T>
T value_at(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

TEST(HitFile, NpyHasTheDocumentedType) {
  const TempDir dir;
  write(dir.path("hits.npy"), all_closest_columns(), 3);
  const std::string file = dir.read("hits.npy");
  const auto header = parse_npy_header(std::as_bytes(std::span(file)));
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_EQ(header->dtype,
            "[('t', '<f8'), ('node', '<u8'), ('primitive', '<u4'), ('u', '<f4'), ('v', '<f4'), "
            "('nx', '<f4'), "
            "('ny', '<f4'), ('nz', '<f4')]");
  EXPECT_EQ(header->shape, std::vector<std::uint64_t>{3});
  const std::size_t row = 8 + 8 + 4 + 5 * 4;
  const std::size_t start = header->data_offset;
  ASSERT_EQ(file.size(), start + 3 * row);
  EXPECT_EQ(value_at<double>(file, start), 1.5);
  EXPECT_EQ(value_at<std::uint64_t>(file, start + 8), 7U);
  EXPECT_EQ(value_at<std::uint32_t>(file, start + 16), 3U);
  EXPECT_EQ(value_at<float>(file, start + 24), 0.5F);
  EXPECT_EQ(value_at<float>(file, start + 36), 1.0F);
  EXPECT_TRUE(std::isinf(value_at<double>(file, start + row)));
}

TEST(HitFile, AnUnknownNumberOfRowsIsFilledInAtTheEnd) {
  const TempDir dir;
  write(dir.path("known.npy"), {HitColumn::kT}, 3);
  write(dir.path("unknown.npy"), {HitColumn::kT}, std::nullopt);
  EXPECT_EQ(dir.read("known.npy"), dir.read("unknown.npy"));
}

TEST(HitFile, CsvHasTheSameNames) {
  const TempDir dir;
  write(dir.path("hits.csv"), all_closest_columns(), 3);
  EXPECT_EQ(dir.read("hits.csv"),
            "t,node,primitive,u,v,nx,ny,nz\n"
            "1.5,7,3,0.25,0.5,0,0,1\n"
            "inf,0,0,0,0,0,0,0\n"
            "nan,0,0,0,0,0,0,0\n");
}

TEST(HitFile, AnyIsOneByteARay) {
  const TempDir dir;
  write(dir.path("any.npy"), {HitColumn::kHit}, 3);
  const std::string file = dir.read("any.npy");
  const auto header = parse_npy_header(std::as_bytes(std::span(file)));
  ASSERT_TRUE(header);
  EXPECT_EQ(header->dtype, "[('hit', '|u1')]");
  EXPECT_EQ(file.substr(header->data_offset), std::string("\1\0\2", 3));
}

TEST(HitFile, WorkIsWrittenWithoutItsFlag) {
  const TempDir dir;
  write(dir.path("work.csv"), {HitColumn::kHit, HitColumn::kWork}, 3);
  EXPECT_EQ(dir.read("work.csv"), "hit,work\n1,5\n0,2\n2,0\n");
}

TEST(HitFile, WithoutACommitNoFileIsWritten) {
  const TempDir dir;
  {
    auto file = HitFile::open(dir.path("hits.npy"), all_closest_columns(), {.rows = 3});
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write(kHits, 3));
  }
  EXPECT_EQ(dir.names(), "");
}

}  // namespace
}  // namespace sightline::client::cli::files
