// Products that Assimp reads in part, each made from a file that it reads as a whole.
#include "client/importer/ifc_products.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "client/importer/assimp_import.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

// Two products, with a square each. The shape of the second one is #120, its items are in #108.
constexpr const char* kSquares = R"(ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','',(''),(''),'','','');
FILE_SCHEMA(('IFC2X3'));
ENDSEC;
DATA;
#1=IFCPERSON($,$,'p',$,$,$,$,$);
#2=IFCORGANIZATION($,'o',$,$,$);
#3=IFCPERSONANDORGANIZATION(#1,#2,$);
#4=IFCAPPLICATION(#2,'1','a','a');
#5=IFCOWNERHISTORY(#3,#4,$,.ADDED.,$,$,$,0);
#6=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);
#7=IFCUNITASSIGNMENT((#6));
#8=IFCCARTESIANPOINT((0.,0.,0.));
#9=IFCAXIS2PLACEMENT3D(#8,$,$);
#10=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#9,$);
#11=IFCPROJECT('0000000000000000000000',#5,'p',$,$,$,$,(#10),#7);
#12=IFCLOCALPLACEMENT($,#9);
#13=IFCBUILDING('0000000000000000000001',#5,'b',$,$,#12,$,$,.ELEMENT.,$,$,$);
#14=IFCRELAGGREGATES('0000000000000000000002',#5,$,$,#11,(#13));
#15=IFCRELCONTAINEDINSPATIALSTRUCTURE('0000000000000000000003',#5,$,$,(#111,#121),#13);
#20=IFCDIRECTION((0.,0.,1.));
#21=IFCCARTESIANPOINT((0.,0.));
#22=IFCAXIS2PLACEMENT2D(#21,$);
#23=IFCRECTANGLEPROFILEDEF(.AREA.,$,#22,4.,2.);
#24=IFCEXTRUDEDAREASOLID(#23,#9,#20,2.);
#101=IFCCARTESIANPOINT((4.,0.,0.));
#102=IFCCARTESIANPOINT((4.,3.,0.));
#103=IFCCARTESIANPOINT((0.,3.,0.));
#104=IFCPOLYLOOP((#8,#101,#102,#103));
#105=IFCFACEOUTERBOUND(#104,.T.);
#106=IFCFACE((#105));
#107=IFCCONNECTEDFACESET((#106));
#108=IFCFACEBASEDSURFACEMODEL((#107));
#109=IFCSHAPEREPRESENTATION(#10,'Body','SurfaceModel',(#108));
#110=IFCPRODUCTDEFINITIONSHAPE($,$,(#109));
#111=IFCBUILDINGELEMENTPROXY('0000000000000000000004',#5,'a',$,$,#12,#110,$,$);
#119=IFCSHAPEREPRESENTATION(#10,'Body','SweptSolid',(#24));
#120=IFCPRODUCTDEFINITIONSHAPE($,$,(#119));
#121=IFCBUILDINGELEMENTPROXY('0000000000000000000005',#5,'b',$,$,#12,#120,$,$);
ENDSEC;
END-ISO-10303-21;
)";

// The file with `to` in place of `from`, and more statements.
std::string changed(const std::string& from, const std::string& to, const std::string& more = "") {
  std::string text = kSquares;
  text.insert(text.rfind("ENDSEC;"), more);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// The kinds of the warnings and of the notes of an import, with their first statements.
std::string kinds_of(const std::string& text) {
  const tests::TempDir folder;
  const auto scene = import_scene(folder.write("a.ifc", text), {UpAxis::kZ, {}});
  if (!scene) return scene.error().message;
  std::string kinds;
  for (const Warning& warning : scene->warnings) {
    if (warning.kind == "open_edges" || warning.kind == "solid_not_closed") continue;
    kinds += fmt::format("{}{} {}", kinds.empty() ? "" : ", ", warning.kind, warning.first);
  }
  return kinds;
}

TEST(IfcProducts, ThatAreReadAsAWholeAreSilent) {
  EXPECT_EQ(kinds_of(kSquares), "");
  const std::string mapped =
      "#30=IFCREPRESENTATIONMAP(#9,#119);\n"
      "#31=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#8,$,$);\n#32=IFCMAPPEDITEM(#30,#31);\n";
  EXPECT_EQ(kinds_of(changed("#109=IFCSHAPEREPRESENTATION(#10,'Body','SurfaceModel',(#108))",
                             mapped + "#109=IFCSHAPEREPRESENTATION(#10,'Body','x',(#32,#108))")),
            "");
  EXPECT_EQ(kinds_of(changed("(#109)", "(#39,#109)",
                             "#38=IFCPOLYLINE((#8,#101));\n"
                             "#39=IFCSHAPEREPRESENTATION(#10,'Axis','Curve2D',(#38));\n")),
            "")
      << "an axis is no part";
}

TEST(IfcProducts, ItemsOfOtherTypesAreLeftOut) {
  const std::string item = "#108=IFCFACEBASEDSURFACEMODEL((#107));";
  for (const char* const other :
       {"#108=IFCFACE((#105));", "#108=IFCPOLYLOOP((#8,#101,#102,#103));",
        "#108=IFCBLOCK(#9,1.,1.,1.);", "#108=IFCCSGSOLID(#40);\n#40=IFCBLOCK(#9,1.,1.,1.);",
        "#108=IFCPLANE(#9);", "#108=IFCHALFSPACESOLID(#40,.F.);\n#40=IFCPLANE(#9);",
        "#108=IFCGEOMETRICSET((#40));\n#40=IFCPLANE(#9);"})
    EXPECT_EQ(kinds_of(changed(item, other)), "parts_left_out #111") << other;
  EXPECT_EQ(kinds_of(changed("(#108));", "(#108,#106));")), "parts_left_out #111") << "one of two";
  EXPECT_EQ(kinds_of(changed("(#24)", "(#42)",
                             "#40=IFCSHAPEREPRESENTATION(#10,'Body','x',(#43));\n"
                             "#41=IFCREPRESENTATIONMAP(#9,#40);\n#42=IFCMAPPEDITEM(#41,#44);\n"
                             "#43=IFCBLOCK(#9,1.,1.,1.);\n"
                             "#44=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#8,$,$);\n")),
            "parts_left_out #121")
      << "mapped";
}

TEST(IfcProducts, OperandsAndProfilesOfOtherTypesAreSaid) {
  const std::string profile = "#23=IFCRECTANGLEPROFILEDEF(.AREA.,$,#22,4.,2.);";
  for (const char* const other :
       {"#23=IFCELLIPSEPROFILEDEF(.AREA.,$,#22,4.,2.);",
        "#23=IFCTSHAPEPROFILEDEF(.AREA.,$,#22,4.,2.,0.1,0.1,$,$,$,$,$,$);",
        "#23=IFCLSHAPEPROFILEDEF(.AREA.,$,#22,4.,2.,0.1,$,$,$,$,$);"})
    EXPECT_EQ(kinds_of(changed(profile, other)), "parts_left_out #121, assimp ") << other;
  for (const char* const operation : {"UNION", "INTERSECTION"}) {
    EXPECT_EQ(kinds_of(changed("(#24)", "(#45)",
                               fmt::format("#45=IFCBOOLEANRESULT(.{}.,#24,#24);\n", operation))),
              "parts_left_out #121, assimp ");
  }
  EXPECT_EQ(kinds_of(changed("'a',$,$,#12", "'a',$,$,#46",
                             "#46=IFCGRIDPLACEMENT(#47,$);\n"
                             "#47=IFCVIRTUALGRIDINTERSECTION((#48,#48),(0.,0.));\n"
                             "#48=IFCGRIDAXIS($,#49,.T.);\n#49=IFCPOLYLINE((#8,#101));\n")),
            "assimp ");
}

TEST(IfcProducts, ShapesThatAssimpChangesAreSaid) {
  const std::string profile = "#23=IFCRECTANGLEPROFILEDEF(.AREA.,$,#22,4.,2.);";
  const std::vector<std::pair<std::string, std::string>> profiles{
      {"#23=IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,#22,4.,2.,0.1,$,$);", "filled #23"},
      {"#23=IFCCIRCLEHOLLOWPROFILEDEF(.AREA.,$,#22,4.,0.1);", "filled #23"},
      {"#23=IFCROUNDEDRECTANGLEPROFILEDEF(.AREA.,$,#22,4.,2.,0.1);", "corners_sharp #23"},
      {"#23=IFCISHAPEPROFILEDEF(.AREA.,$,#22,4.,2.,0.1,0.1,$);", "profiles_moved #23"}};
  for (const auto& [other, wanted] : profiles)
    EXPECT_EQ(kinds_of(changed(profile, other)), wanted) << other;
  EXPECT_EQ(kinds_of(changed("(#104,.T.)", "(#104,.F.)")), "faces_turned #105");
}

TEST(IfcProducts, OtherRepresentationsAndProductsWithoutAWay) {
  EXPECT_EQ(
      kinds_of(changed("(#119)", "(#39,#119)",
                       "#39=IFCSHAPEREPRESENTATION(#10,'Clearance','SurfaceModel',(#108));\n")),
      "no_body #121");
  EXPECT_EQ(kinds_of(changed("(#111,#121)", "(#111)")), "parts_left_out #121");
  EXPECT_EQ(kinds_of(changed("#121=IFCBUILDINGELEMENTPROXY('0000000000000000000005',#5,'b',$,$,#12,"
                             "#120,$,$)",
                             "#121=IFCSPACE('0000000000000000000005',#5,'b',$,$,#12,#120,$,"
                             ".ELEMENT.,.INTERNAL.,$)")),
            "spaces_left_out #121");
}

TEST(IfcProducts, OfAFileInFeetAreInFeet) {
  const tests::TempDir folder;
  const auto scene = import_scene(
      folder.write("a.ifc", changed("#6=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);",
                                    "#6=IFCCONVERSIONBASEDUNIT(#51,.LENGTHUNIT.,'FOOT',#52);",
                                    "#51=IFCDIMENSIONALEXPONENTS(1,0,0,0,0,0,0);\n"
                                    "#52=IFCMEASUREWITHUNIT(IFCLENGTHMEASURE(0.3048),#53);\n"
                                    "#53=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n")));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_DOUBLE_EQ(scene->meters_per_unit, 0.3048);
}

TEST(IfcProducts, AGlobalIdIsTheEndOfAName) {
  FileNode node;
  node.name = "IfcWall_a_b_0123456789012345678901";
  EXPECT_EQ(global_id_of(node), "0123456789012345678901");
  node.name = "IfcMappedItem";
  EXPECT_EQ(global_id_of(node), "");
}

}  // namespace
}  // namespace sightline::client::importer
