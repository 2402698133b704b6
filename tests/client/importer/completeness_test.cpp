// Files that were cut off, and whole ones that look similar.
#include "client/importer/completeness.h"

#include <gtest/gtest.h>

#include <string>

#include "client/importer/ply_size.h"

namespace sightline::client::importer {
namespace {

using namespace std::string_literals;

enum class Verdict { kWhole, kDoubt, kCut };

Verdict verdict(const std::string& name, const std::string& bytes) {
  const auto doubts = check_complete(name, bytes);
  if (!doubts) return Verdict::kCut;
  return doubts->empty() ? Verdict::kWhole : Verdict::kDoubt;
}

TEST(Completeness, AStepFileHasALastLine) {
  const std::string start = "ISO-10303-21;\nHEADER;\nENDSEC;\n";
  EXPECT_EQ(verdict("a.ifc", start + "END-ISO-10303-21;"), Verdict::kWhole);
  EXPECT_EQ(verdict("a.ifc", start + "END-ISO-10303-21;\r\n \n"), Verdict::kWhole);
  EXPECT_EQ(verdict("a.ifc", start + "END-ISO-10303-2"), Verdict::kCut);
  EXPECT_EQ(verdict("a.ifc", start), Verdict::kCut);
}

TEST(Completeness, TheLastStatementOfAnObjFileIsWhole) {
  const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* end : {"", "f 1 2 3\n", "f 1 2 3\r\n", "# the end", "f 1 2 3\n  \n"})
    EXPECT_EQ(verdict("a.obj", start + end), Verdict::kWhole) << end;
  for (const char* end : {"f 1 2 3", "v 0 0 1", "f 1/1/1 2/2/2 3//3", "usemtl a", "f -1 -2 -3"})
    EXPECT_EQ(verdict("a.obj", start + end), Verdict::kDoubt) << end;
  for (const char* end : {"f 1 2", "f", "v 0 0", "v 0 0 1e", "v 0 0 -", "f 1 2 3/", "f 1 2 -"})
    EXPECT_EQ(verdict("a.obj", start + end), Verdict::kCut) << end;
  EXPECT_EQ(verdict("a.OBJ", start + "f 1"), Verdict::kCut);
}

TEST(Completeness, AnAsciiStlFileHasAnEnd) {
  const std::string start = "solid a\nfacet normal 0 0 1\nouter loop\n";
  EXPECT_EQ(verdict("a.stl", start + "endsolid a\n"), Verdict::kWhole);
  EXPECT_EQ(verdict("a.stl", start + "ENDSOLID"), Verdict::kWhole);
  EXPECT_EQ(verdict("a.stl", start + "endfacet\n"), Verdict::kDoubt);
  EXPECT_EQ(verdict("a.stl", "solid facet"s + '\0'), Verdict::kWhole) << "binary";
}

std::string ply(const std::string& format, const std::string& length, std::size_t bytes) {
  return "ply\nformat " + format +
         " 1.0\nelement vertex 2\nproperty float x\nproperty double y\n"
         "element face 2\nproperty list uchar int vertex_indices\nproperty uchar flags\n"
         "end_header\n" +
         std::string(24, '\0') + length + std::string(bytes, '\0');
}

TEST(Completeness, ABinaryPlyFileHoldsItsElements) {
  // The first face has 3 corners, the second none.
  const std::string three = "\3";
  EXPECT_EQ(bytes_missing_in_ply(ply("binary_little_endian", three, 13 + 2)), 0U);
  EXPECT_EQ(bytes_missing_in_ply(ply("binary_little_endian", three, 13 + 2 + 9)), 0U);
  EXPECT_EQ(bytes_missing_in_ply(ply("binary_little_endian", three, 13 + 1)), 1U);
  EXPECT_EQ(bytes_missing_in_ply(ply("binary_big_endian", three, 13)), 2U);
  EXPECT_GT(bytes_missing_in_ply(ply("binary_little_endian", three, 4)), 0U);
  EXPECT_EQ(bytes_missing_in_ply(ply("ascii", three, 4)), 0U);
  EXPECT_EQ(verdict("a.ply", ply("binary_little_endian", three, 4)), Verdict::kCut);
}

TEST(Completeness, HugeCountsInPlyDoNotOverflow) {
  const auto check = [](const std::string& element) {
    return bytes_missing_in_ply("ply\nformat binary_big_endian 1.0\n" + element +
                                "end_header\n\377\377\377\377\377\377\377\377");
  };
  EXPECT_GT(check("element a 18446744073709551615\nproperty double x\n"), 1U << 30U);
  EXPECT_GT(check("element a 9\nproperty list uint double x\n"), 1U << 30U);
  EXPECT_EQ(check("element a 18446744073709551615\n"), 0U);
  EXPECT_EQ(check("property double x\n"), 0U);
  EXPECT_EQ(check("element a 1\nproperty quad x\n"), 0U);
}

}  // namespace
}  // namespace sightline::client::importer
