// Files on which Assimp would hang or exhaust memory, and similar valid ones.
#include "client/importer/preflight.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::client::importer {
namespace {

constexpr const char* kPly = R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
)";

std::string error_of(const Status& status) { return status ? "" : status.error().message; }

std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(Preflight, AcceptsAValidFile) {
  EXPECT_EQ(error_of(preflight(kPly)), "");
  EXPECT_EQ(error_of(preflight(changed(kPly, "end_header", "end_header\r"))), "");
  EXPECT_EQ(error_of(preflight(changed(kPly, "end_header", " end_header "))), "");
  EXPECT_EQ(error_of(preflight("v 0 0 0\n")), "");
  EXPECT_EQ(error_of(preflight({})), "");
}

TEST(Preflight, RefusesAPlyHeaderWithoutAnEnd) {
  for (const char* end :
       {"", "end_headers", "the_end_header", "end", "list end_header", "comment end_header"}) {
    const auto status = preflight(changed(kPly, "end_header", end));
    EXPECT_NE(error_of(status).find("without end_header"), std::string::npos) << end;
  }
}

TEST(Preflight, RefusesAPlyFileTooSmallForItsElements) {
  const auto check = [&](const std::string& count) {
    const std::string element = "element vertex ";
    return error_of(preflight(changed(kPly, element + "3", element + count)));
  };
  EXPECT_EQ(check("100"), "");
  EXPECT_NE(check("4000000000").find("4000000001 elements"), std::string::npos);
  EXPECT_NE(check("18446744073709551615"), "");
}

}  // namespace
}  // namespace sightline::client::importer
