// STEP files that were cut off, and whole ones.
#include "client/importer/completeness.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::client::importer {
namespace {

TEST(Completeness, AStepFileHasALastLine) {
  const std::string start = "ISO-10303-21;\nHEADER;\nENDSEC;\n";
  EXPECT_TRUE(check_complete(start + "END-ISO-10303-21;"));
  EXPECT_TRUE(check_complete(start + "END-ISO-10303-21;\r\n \n"));
  EXPECT_FALSE(check_complete(start + "END-ISO-10303-2"));
  EXPECT_FALSE(check_complete(start));
  EXPECT_TRUE(check_complete("v 0 0 0"));
  EXPECT_TRUE(check_complete(""));
}

}  // namespace
}  // namespace sightline::client::importer
