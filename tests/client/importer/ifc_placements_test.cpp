// Placements that float32 holds, and others, and units of length.
#include "client/importer/ifc_placements.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace sightline::client::importer {
namespace {

// A wall on a site. `directions`: of the site's axes.
double loss_of(const std::string& site, const std::string& wall,
               const std::string& directions = "$,$") {
  const std::string text = fmt::format(
      "#1=IFCCARTESIANPOINT(({}));\n#2=IFCAXIS2PLACEMENT3D(#1,{});\n#3=IFCLOCALPLACEMENT($,#2);\n"
      "#4=IFCCARTESIANPOINT(({}));\n#5=IFCAXIS2PLACEMENT3D(#4,$,$);\n"
      "#6=IFCLOCALPLACEMENT(#3,#5);\n#7=IFCWALL('a',$,$,$,$,#6,$,$);\n"
      "#8=IFCDIRECTION((0.,0.,1.));\n#9=IFCDIRECTION((0.6,0.8,0.));\n",
      site, directions, wall);
  const auto losses = ifc_losses(Statements(text));
  return losses.contains("a") ? losses.at("a") : 0;
}

TEST(IfcPlacements, NumbersThatFloatsHoldLoseNothing) {
  for (const char* const site : {"0.,0.,0.", "4512345.,123456.,12.", "-4512345.5,0.25,1.E3"})
    EXPECT_EQ(loss_of(site, "1.,2.,3."), 0) << site;
}

TEST(IfcPlacements, FarOffNumbersLoseWhatFloatsLose) {
  EXPECT_NEAR(loss_of("4512345.7,0.,0.", "0.,0.,0."), 0.2, 1e-3);
  EXPECT_NEAR(loss_of("4512345.,0.,0.", "0.2,0.,0."), 0.2, 1e-3);
  EXPECT_NEAR(loss_of("0.,0.,16777217.", "0.,0.,0."), 1, 1e-3);
  EXPECT_GT(loss_of("4512345.,0.,0.", "1.,0.,0.", "#8,#9"), 0.05) << "turned";
}

double meters(const std::string& units) {
  return ifc_meters_per_unit(Statements("#1=IFCUNITASSIGNMENT((#2));\n" + units));
}

TEST(IfcPlacements, UnitsThatAssimpDoesNotConvert) {
  EXPECT_EQ(ifc_meters_per_unit(Statements("")), 1);
  EXPECT_EQ(meters("#2=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);\n"), 1);
  const auto based = [&](const char* factor, const char* prefix) {
    return meters(
        fmt::format("#2=IFCCONVERSIONBASEDUNIT($,.LENGTHUNIT.,'u',#4);\n"
                    "#4=IFCMEASUREWITHUNIT(IFCLENGTHMEASURE({}),#5);\n"
                    "#5=IFCSIUNIT(*,.LENGTHUNIT.,{},.METRE.);\n",
                    factor, prefix));
  };
  EXPECT_DOUBLE_EQ(based("0.3048", "$"), 0.3048);
  EXPECT_DOUBLE_EQ(based("304.8", ".MILLI."), 0.3048);
  EXPECT_DOUBLE_EQ(based(" 2.54", ".CENTI."), 0.0254);
  EXPECT_EQ(based("$", "$"), 0);
}

}  // namespace
}  // namespace sightline::client::importer
