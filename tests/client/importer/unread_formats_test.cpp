// Formats that are not read are called by their names, by their contents before their extensions.
#include "client/importer/unread_formats.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline::client::importer {
namespace {

struct Refused {
  const char* name;
  std::string contents;
  const char* said;
};

std::string step_of(const std::string& schema) {
  return "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_SCHEMA(" + schema +
         ");\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n";
}

std::string refusal_of(const Status& status) { return status ? "" : status.error().message; }

TEST(UnreadFormats, AreCalledByTheirNames) {
  const std::string iges =
      std::string(72, ' ') + "S      1\n" + std::string(72, ' ') + "G      1\n";
  const std::vector<Refused> files{
      {"a.wrl", "#VRML V2.0 utf8\n", "VRML"},
      {"a.obj", "#VRML V1.0 ascii\n", "VRML"},
      {"a.x3d", "<?xml version=\"1.0\"?>\n<X3D profile='Full'>", "X3D"},
      {"a.xml", "<?xml version=\"1.0\"?>\n<!DOCTYPE X3D><X3D>", "X3D"},
      {"a.x3dv", "#X3D V3.2 utf8\n", "X3D"},
      {"a.usda", "#usda 1.0\n", "USD"},
      {"a.usd", "PXR-USDC\0\0", "USD"},
      {"a.usdz", "PK\x03\x04", "USD"},
      {"a", "#usda 1.0\n", "USD"},
      {"a.step", step_of("('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 }')"), "AP214"},
      {"a.stp", step_of("('CONFIG_CONTROL_DESIGN')"), "AP203"},
      {"a.p21", step_of("('AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF')"), "AP242"},
      {"a.stp", "", "STEP"},
      {"a.ifc", step_of("('IFC4')"), "IFC4,"},
      {"a.ifc", step_of("(('IFC4X3_ADD2'))"), "IFC4X3_ADD2"},
      {"a.ifc", step_of("('IFC2X2_FINAL')"), "IFC2X2_FINAL"},
      {"a.ifc", step_of("('ifc2x3')"), "ifc2x3"},
      {"a.ifczip", "PK\x03\x04", "ifcZIP"},
      {"a.ifcxml", "<?xml version=\"1.0\"?>\n<ex:iso_10303_28 ", "ifcXML"},
      {"a.zip", "PK\x03\x04 house.ifc PK\x01\x02 house.ifc", "ifcZIP"},
      {"a.3mf", "PK\x03\x04", "3MF"},
      {"a.zip", "PK\x03\x04 3D/3dmodel.model", "3MF"},
      {"a.zip", "PK\x03\x04 notes.txt", "ZIP"},
      {"a.blend", "BLENDER-v300", "Blender"},
      {"a.skp", std::string("\xff\xfe\xff\x0eS\0k\0e\0", 10), "SketchUp"},
      {"a.dwg", "AC1032", "DWG"},
      {"a.dxf", "0\r\nSECTION\r\n", "DXF"},
      {"a.3ds", "", "3DS"},
      {"a.3dm", "3D Geometry File Format ", "Rhino"},
      {"a.x_t", "**ABCDEFGHIJKLMNOPQRSTUVWXYZ", "Parasolid"},
      {"a.igs", "", "IGES"},
      {"a.dat", iges, "IGES"},
      {"a.las", "LASF", "LAS"},
      {"a.laz", "LASF", "LAS"},
      {"a.pcd", "# .PCD v.7\n", "PCD"},
      {"a.e57", "ASTM-E57", "E57"},
      {"a.xyz", "0 0 0\n", "point"},
      {"a.json", "{\"type\": \"CityJSON\", \"version\": \"1.1\"}", "CityJSON"},
      {"a.gml", "<?xml version=\"1.0\"?>\n<core:CityModel xmlns", "CityGML"},
      {"a.off", "OFF\n", "OFF"},
      {"a.lwo", "FORM\0\0\0\0LWO2", "LightWave"},
      {"a.glb", "<!DOCTYPE html><html>", "HTML"},
      {"a.ply", "version https://git-lfs.github.com/spec/v1\n", "Git LFS"},
      {"a.glb", "\x1f\x8b\x08", "compressed"},
      {"a.png", "\x89PNG", "image"},
      {"a.qqq", "what", ".qqq"},
      {"a", "what", "no known format"}};
  for (const Refused& file : files) {
    const std::string error = refusal_of(check_format(file.name, file.contents));
    EXPECT_NE(error.find(file.said), std::string::npos) << file.name << ": " << error;
    EXPECT_NE(error.find("Formats that are read: glTF"), std::string::npos) << file.name;
  }
}

TEST(UnreadFormats, WhatIsReadPasses) {
  const std::vector<Refused> files{
      {"a.ifc", step_of("('IFC2X3')"), ""},
      {"a.IFC", step_of("( 'IFC2X3_TC1' )"), ""},
      {"a.gltf", "{\"asset\": {\"generator\": \"CityJSON tool\"}}", ""},
      {"a.obj", "v 0 0 0\n", ""},
      {"a.OBJ", "\xef\xbb\xbfv 0 0 0\n", ""},
      {"a.stl", "solid AC10", ""},
      {"a.dae", "<?xml version=\"1.0\"?><COLLADA>", ""},
      {"a", "<?xml version=\"1.0\"?><COLLADA>", ""},
      {"a.xml", "\xef\xbb\xbf<COLLADA>", ""},
      {"a", "glTF\x02", ""},
      {"mesh", "ply\nformat", ""},
      {"a", "AC3Db", ""},
      {"a.ply", "", ""}};
  for (const Refused& file : files)
    EXPECT_EQ(refusal_of(check_format(file.name, file.contents)), "") << file.name;
}

}  // namespace
}  // namespace sightline::client::importer
