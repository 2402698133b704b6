// Sentences that Assimp logs.
#include "client/importer/assimp_complaints.h"

#include <gtest/gtest.h>

#include <assimp/DefaultLogger.hpp>

namespace sightline::client::importer {
namespace {

TEST(AssimpComplaints, AreErrorsAndWarningsThatConcernTheScene) {
  AssimpComplaints complaints;
  ASSIMP_LOG_WARN("IFC: skipping unknown IfcProfileDef entity, type is ", "x");
  ASSIMP_LOG_ERROR("AC3D: Unexpected\ntoken");
  ASSIMP_LOG_ERROR("AC3D: Unexpected\ntoken");
  ASSIMP_LOG_INFO("a fact");
  for (const char* const harmless :
       {"No material specified", "Unable to find light for ID \"a\"", "UVs are declared",
        "FBX-DOM: unsupported, newer format version", "shading mode not recognized"})
    ASSIMP_LOG_WARN(harmless);
  EXPECT_EQ(complaints.take(),
            (std::vector<std::string>{"IFC: skipping unknown IfcProfileDef entity, type is x",
                                      "AC3D: Unexpected token"}));
}

TEST(AssimpComplaints, ThatAreManyAreCounted) {
  AssimpComplaints complaints;
  for (int i = 0; i < 9; ++i) ASSIMP_LOG_WARN("Collada: no ", i);
  const std::vector<std::string> lines = complaints.take();
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[3], "6 more complaints, and went on");
}

}  // namespace
}  // namespace sightline::client::importer
