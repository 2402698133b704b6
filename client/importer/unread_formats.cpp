// Tables of names, extensions and first bytes.
#include "client/importer/unread_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

#include "client/importer/extension.h"
#include "client/importer/imported_scene.h"
#include "client/importer/node_name.h"

namespace sightline::client::importer {
namespace {

constexpr std::size_t kHead = 4096;  // bytes that are looked at

// What makes a file that is read.
constexpr std::string_view kBlender = "convert it to glTF with Blender, for example";
constexpr std::string_view kMeshLab = "convert it to glTF or PLY with MeshLab, for example";
constexpr std::string_view kFreeCad = "convert it to glTF or STL with FreeCAD, for example";
constexpr std::string_view kMaker = "export glTF from the program that made it";
constexpr std::string_view kAssimp =
    "convert it to glTF with Blender or 'assimp export', for example";
constexpr std::string_view kPoints =
    "it has points and no faces; make a surface of them, with CloudCompare or MeshLab, for example";
constexpr std::string_view kUnpack = "unpack it, and import the scene file in it";
constexpr std::string_view kCity =
    "convert it to OBJ or glTF, with citygml-tools and cjio, for example";
constexpr std::string_view kNoScene = "it holds no scene";

struct Format {
  std::string_view name;
  std::string_view remedy;
  std::string_view extensions;  // in blanks
};

constexpr Format kVrml{"VRML", "convert it to glTF or PLY with MeshLab or Blender, for example",
                       " wrl vrml wrz "};
constexpr Format kX3d{"X3D", "convert it to glTF or PLY with MeshLab or Blender, for example",
                      " x3d x3dv x3db x3dz "};
constexpr Format kUsd{"USD", kBlender, " usd usda usdc usdz "};
constexpr Format kStepFile{"STEP", kFreeCad, " stp step p21 stpz "};
constexpr Format kThreeMf{
    "3MF", "convert it to STL or OBJ with PrusaSlicer or MeshLab, for example", " 3mf "};
constexpr Format kBlend{"a Blender file", "export glTF from Blender", " blend "};
constexpr Format kSketchUp{"a SketchUp file", "export Collada or glTF from SketchUp", " skp "};
constexpr Format kDwg{"AutoCAD DWG", kMaker, " dwg "};
constexpr Format kDxf{"DXF", kFreeCad, " dxf "};
constexpr Format kRhino{"a Rhino file", "export glTF or OBJ from Rhino", " 3dm "};
constexpr Format kParasolid{"Parasolid", kMaker, " x_t x_b xmt_txt xmt_bin "};
constexpr Format kIges{"IGES", kFreeCad, " igs iges "};
constexpr Format kLas{"an LAS point cloud", kPoints, " las laz "};
constexpr Format kPcd{"a PCD point cloud", kPoints, " pcd "};
constexpr Format kE57{"an E57 point cloud", kPoints, " e57 "};
constexpr Format kCityJson{"CityJSON", kCity, " cityjson "};
constexpr Format kCityGml{"CityGML", kCity, " citygml "};
constexpr Format kIfcXml{"ifcXML", "save it as IFC2X3 in the STEP form (.ifc)", " ifcxml "};
constexpr Format kIfcZip{"a packed IFC file (ifcZIP)", "unpack it, and import the .ifc file in it",
                         " ifczip "};
constexpr Format kZae{"packed Collada", "unpack it, and import the .dae file in it", " zae "};
constexpr Format kThreeDs{"3DS", kAssimp, " 3ds prj "};
constexpr Format kLightWave{"LightWave", kAssimp, " lwo lws lxo "};
constexpr Format kDirectX{"DirectX X", kAssimp, " x "};
constexpr Format kOff{"OFF", kMeshLab, " off "};
constexpr Format kOgre{"Ogre", kAssimp, " mesh "};
constexpr Format kMd2{"Quake MD2", kAssimp, " md2 "};
constexpr Format kMd3{"Quake MD3", kAssimp, " md3 "};
constexpr Format kMd5{"Doom MD5", kAssimp, " md5mesh md5anim md5camera "};
constexpr Format kAse{"3ds Max ASE", kAssimp, " ase ask "};
constexpr Format kAmf{"AMF", "convert it to STL or OBJ with PrusaSlicer or MeshLab, for example",
                      " amf "};
constexpr Format kVtk{"VTK", "convert it to PLY or STL with ParaView, for example",
                      " vtk vtp vtu vti vts vtr "};
constexpr Format kGmsh{"Gmsh", "convert it to STL with Gmsh", " msh "};
constexpr Format kTiles{"3D Tiles", "take the glTF out of it, with 3d-tiles-tools, for example",
                        " b3dm i3dm pnts cmpt "};
constexpr Format kDraco{"a Draco mesh", "decode it to PLY or OBJ with draco_decoder", " drc "};
constexpr Format kZip{"a ZIP archive", kUnpack, " zip kmz 7z rar "};
constexpr Format kPacked{"a compressed file", kUnpack, " gz xz bz2 zst tgz tar "};
constexpr Format kImage{"an image", kNoScene,
                        " png jpg jpeg bmp tif tiff gif webp hdr exr tga ktx2 "};
constexpr Format kPdf{"PDF", kNoScene, " pdf "};
constexpr Format kHtml{"an HTML page", "it holds no scene; a download may have failed",
                       " html htm "};
constexpr Format kLfs{"a Git LFS pointer", "fetch the file that it stands for: git lfs pull", ""};

// Formats that are known by extension alone.
constexpr Format kOthers[] = {
    {"ACIS", kMaker, " sat sab "},
    {"JT", kMaker, " jt "},
    {"a CATIA file", kMaker, " catpart catproduct "},
    {"a SolidWorks file", kMaker, " sldprt sldasm "},
    {"an Inventor file", kMaker, " ipt iam "},
    {"a Creo file", kMaker, " prt "},
    {"a Solid Edge file", kMaker, " par psm "},
    {"BREP", kFreeCad, " brep brp "},
    {"a FreeCAD file", "export glTF or STL from FreeCAD", " fcstd "},
    {"an OpenSCAD file", "export STL from OpenSCAD", " scad "},
    {"a Revit file", "export IFC2X3 from Revit", " rvt rfa "},
    {"a Navisworks file", "export FBX from Navisworks", " nwd nwc nwf "},
    {"a 3ds Max file", "export glTF or FBX from 3ds Max", " max "},
    {"a Maya file", "export FBX from Maya", " ma mb "},
    {"a Cinema 4D file", "export glTF or FBX from Cinema 4D", " c4d "},
    {"a ZBrush file", "export OBJ from ZBrush", " ztl zpr "},
    {"a Houdini file", "export glTF from Houdini", " hip hipnc bgeo geo "},
    {"Alembic", kBlender, " abc "},
    {"a Radiance scene", "convert its meshes to OBJ", " rad oct "},
    {"a point list", kPoints, " xyz pts ptx asc csv "},
    {"text", kNoScene, " txt md log xml json "},
    {"a Gaussian splat", kPoints, " splat spz ksplat "},
    {"a point cloud of Potree", kPoints, " copc ept "},
    {"a shapefile", kCity, " shp "},
    {"GeoJSON", kCity, " geojson "},
    {"KML", kUnpack, " kml "},
    {"I3S", kMaker, " slpk "},
    {"a mesh of a solver", kMaker, " med inp unv cgns bdf nas "},
    {"COB", kAssimp, " cob scn "},
    {"NFF", kAssimp, " nff enff "},
    {"B3D", kAssimp, " b3d "},
    {"a motion without a mesh", kNoScene, " bvh vmd "},
    {"MMD", kAssimp, " pmx pmd "},
    {"MilkShape 3D", kAssimp, " ms3d "},
    {"Irrlicht", kAssimp, " irr irrmesh "},
    {"XGL", kAssimp, " xgl zgl "},
    {"Quick3D", kAssimp, " q3o q3s "},
    {"Model 3D", kAssimp, " m3d a3d "},
    {"OpenGEX", kAssimp, " ogex "},
    {"Valve SMD", kAssimp, " smd vta "},
    {"a game's model", kAssimp, " mdl mdc hmp iqm uc 3d pk3 bsp ndo sib ter csm raw dff nif psk "},
    {"a material library", "import the OBJ file that names it", " mtl "},
    {"a buffer of a glTF file", "import the .gltf file that names it", " bin "}};

constexpr const Format* kByExtension[] = {
    &kVrml,    &kX3d,    &kUsd,       &kStepFile, &kThreeMf, &kBlend,     &kSketchUp, &kDwg,
    &kDxf,     &kRhino,  &kParasolid, &kIges,     &kLas,     &kPcd,       &kE57,      &kCityJson,
    &kCityGml, &kIfcXml, &kIfcZip,    &kZae,      &kThreeDs, &kLightWave, &kDirectX,  &kOff,
    &kOgre,    &kMd2,    &kMd3,       &kMd5,      &kAse,     &kAmf,       &kVtk,      &kGmsh,
    &kTiles,   &kDraco,  &kZip,       &kPacked,   &kImage,   &kPdf,       &kHtml};

struct Magic {
  std::string_view bytes;
  const Format& format;
};

// The bytes at the very front.
constexpr Magic kMagics[] = {{"#VRML", kVrml},
                             {"#X3D", kX3d},
                             {"#usda", kUsd},
                             {"PXR-USDC", kUsd},
                             {"BLENDER", kBlend},
                             {"\xff\xfe\xff\x0eS", kSketchUp},
                             {"AC10", kDwg},
                             {"AutoCAD Binary DXF", kDxf},
                             {"3D Geometry File Format", kRhino},
                             {"**ABCDEFGHIJKLMNOPQRSTUVWXYZ", kParasolid},
                             {"LASF", kLas},
                             {"# .PCD", kPcd},
                             {"ASTM-E57", kE57},
                             {"xof 0", kDirectX},
                             {"IDP2", kMd2},
                             {"IDP3", kMd3},
                             {"MD5Version", kMd5},
                             {"*3DSMAX_ASCIIEXPORT", kAse},
                             {"# vtk DataFile", kVtk},
                             {"$MeshFormat", kGmsh},
                             {"b3dm", kTiles},
                             {"i3dm", kTiles},
                             {"pnts", kTiles},
                             {"cmpt", kTiles},
                             {"DRACO", kDraco},
                             {"\x1f\x8b", kPacked},
                             {"\x28\xb5\x2f\xfd", kPacked},
                             {"\xfd"
                              "7zXZ",
                              kPacked},
                             {"BZh", kPacked},
                             {"7z\xbc\xaf", kZip},
                             {"Rar!", kZip},
                             {"\x89PNG", kImage},
                             {"\xff\xd8\xff", kImage},
                             {"GIF8", kImage},
                             {"%PDF", kPdf},
                             {"version https://git-lfs", kLfs}};

// Words near the front of XML, JSON and archives.
constexpr Magic kWords[] = {{"<X3D", kX3d},
                            {"<VTKFile", kVtk},
                            {"CityModel", kCityGml},
                            {"<amf", kAmf},
                            {"ifcXML", kIfcXml},
                            {"iso_10303_28", kIfcXml},
                            {"<!DOCTYPE html", kHtml},
                            {"<!doctype html", kHtml},
                            {"<html", kHtml}};
constexpr Magic kZipped[] = {{"3D/3dmodel.model", kThreeMf},
                             {"3dmodel.model", kThreeMf},
                             {".usd", kUsd},
                             {".ifc", kIfcZip},
                             {".dae", kZae}};

// The text from the first character on that is neither a byte order mark nor a blank.
std::string_view after_blanks(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string_view::npos ? std::string_view() : text.substr(first);
}

const Format* with_extension(std::string_view extension) {
  const std::string word = fmt::format(" {} ", extension);
  const auto has = [&](const Format& format) {
    return !extension.empty() && format.extensions.find(word) != std::string_view::npos;
  };
  for (const Format* const format : kByExtension) {
    if (has(*format)) return format;
  }
  for (const Format& format : kOthers) {
    if (has(format)) return &format;
  }
  return nullptr;
}

const Format* with_word(std::string_view head, std::span<const Magic> words) {
  for (const Magic& magic : words) {
    if (head.find(magic.bytes) != std::string_view::npos) return &magic.format;
  }
  return nullptr;
}

bool is_dxf(std::string_view text) {
  if (!text.starts_with("0\n") && !text.starts_with("0\r\n") && !text.starts_with("999"))
    return false;
  return text.find("SECTION") != std::string_view::npos;
}

// The first line of an IGES file has an S in column 73 and a number behind it.
bool is_iges(std::string_view bytes) {
  return bytes.size() > 80 && bytes[72] == 'S' && bytes.substr(73, 7).find('1') != bytes.npos &&
         bytes.substr(0, 72).find('\n') == bytes.npos;
}

// A ZIP archive lists its files at its end; small ones at their fronts, too.
const Format* in_zip(std::string_view extension, std::string_view bytes) {
  const Format* const by_extension = with_extension(extension);
  if (by_extension != nullptr && by_extension != &kZip) return by_extension;
  const std::size_t tail = std::min<std::size_t>(bytes.size(), 65536);
  const Format* const by_name = with_word(bytes.substr(bytes.size() - tail), kZipped);
  return by_name != nullptr ? by_name : &kZip;
}

const Format* with_contents(std::string_view extension, std::string_view bytes) {
  for (const Magic& magic : kMagics) {
    if (!bytes.starts_with(magic.bytes)) continue;
    const Format* const packed =
        &magic.format == &kPacked && !is_read(extension) ? with_extension(extension) : nullptr;
    return packed != nullptr ? packed : &magic.format;
  }
  if (bytes.starts_with("PK\x03\x04")) return in_zip(extension, bytes);
  if (bytes.starts_with("FORM") && bytes.substr(0, 12).find("LW") != bytes.npos) return &kLightWave;
  if (bytes.starts_with("MM") && bytes.size() > 16 && bytes[6] == '\x02') return &kThreeDs;
  const std::string_view text = after_blanks(bytes.substr(0, kHead));
  if (text.starts_with('<') && text.find("<COLLADA") == text.npos) return with_word(text, kWords);
  if (text.starts_with('{') && text.find("\"CityJSON\"") != text.npos) return &kCityJson;
  if (is_dxf(text)) return &kDxf;
  if (is_iges(bytes)) return &kIges;
  return nullptr;
}

// Whether a file with these contents is read, whatever its extension is.
bool begins_as_read(std::string_view bytes) {
  return bytes.starts_with("glTF") || bytes.starts_with("ply") || bytes.starts_with("AC3D") ||
         bytes.starts_with("Kaydara FBX") ||
         after_blanks(bytes.substr(0, kHead)).find("<COLLADA") != std::string_view::npos;
}

Error not_read(std::string_view what, std::string_view remedy) {
  return import_error(fmt::format("is {}, which is not read; {}. Formats that are read: {}", what,
                                  remedy, kFormatsRead));
}

// The first schema of a STEP file; empty: it states none.
std::string schema_of(std::string_view bytes) {
  const std::string_view header = bytes.substr(0, bytes.find("DATA;"));
  const std::size_t at = header.find("FILE_SCHEMA");
  const std::size_t open = at == header.npos ? at : header.find('\'', at);
  const std::size_t close = open == header.npos ? open : header.find('\'', open + 1);
  if (close == header.npos) return {};
  const std::string_view word = header.substr(open + 1, close - open - 1);
  constexpr std::size_t kLongest = 60;
  return node_name(word.substr(0, std::min(kLongest, word.find_first_of(" {"))));
}

// The application protocol that a schema belongs to, in brackets.
std::string_view protocol_of(std::string_view schema) {
  if (schema.starts_with("CONFIG_CONTROL_DESIGN")) return " (AP203)";
  if (schema.starts_with("AUTOMOTIVE_DESIGN")) return " (AP214)";
  if (schema.starts_with("AP242")) return " (AP242)";
  return {};
}

// Assimp 5.2 has the schema of IFC2X3 alone.
Status check_step(std::string_view bytes) {
  const std::string schema = schema_of(bytes);
  if (schema == "IFC2X3" || schema.starts_with("IFC2X3_")) return {};
  const bool is_cut_off = bytes.find("ENDSEC") == std::string_view::npos;  // reported later
  if (is_cut_off) return {};
  if (schema.empty()) return not_read("a STEP file that states no schema", kStepFile.remedy);
  if (schema.starts_with("IFC") || schema.starts_with("ifc")) {
    return not_read(fmt::format("IFC of the schema {}", schema),
                    "save it as IFC2X3, or convert it to glTF with IfcConvert, for example");
  }
  return not_read(fmt::format("STEP of the schema {}{}", schema, protocol_of(schema)),
                  kStepFile.remedy);
}

}  // namespace

bool is_read(std::string_view extension) {
  constexpr std::string_view kRead = " gltf glb obj ply stl dae ifc ac acc ac3d fbx ";
  return !extension.empty() && kRead.find(fmt::format(" {} ", extension)) != kRead.npos;
}

Status check_format(std::string_view name, std::string_view bytes) {
  const bool has_extension = name.find('.') != std::string_view::npos;
  const std::string extension = has_extension ? extension_of(name) : std::string();
  if (after_blanks(bytes.substr(0, kHead)).starts_with("ISO-10303-21")) return check_step(bytes);
  const Format* format = with_contents(extension, bytes);
  if (format == nullptr) {
    if (is_read(extension) || begins_as_read(bytes)) return {};
    format = with_extension(extension);
  }
  if (format != nullptr) return not_read(format->name, format->remedy);
  return not_read(has_extension ? fmt::format("a .{} file", node_name(extension))
                                : std::string("of no known format"),
                  "convert it to glTF, for example");
}

}  // namespace sightline::client::importer
