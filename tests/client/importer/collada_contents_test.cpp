// Numbers that a Collada file does not have, each made from a file that is right.
#include "client/importer/collada_contents.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "client/importer/assimp_import.h"
#include "client/importer/xml_tags.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::importer {
namespace {

constexpr const char* kTriangle = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="t"><float_array id="b" count="2">0 0</float_array><technique_common>
<accessor source="#b" count="1" stride="2"><param name="S" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#t" offset="1"/><p>0 0 1 0 2 0</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node id="n"><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<translate>1 2 3</translate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>
)";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = kTriangle;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal_of(const std::string& text) {
  const Status checked = check_collada(text);
  return checked ? "" : checked.error().message;
}

TEST(ColladaContents, NumbersThatAreThere) {
  EXPECT_EQ(refusal_of(kTriangle), "");
  EXPECT_EQ(refusal_of(changed("0 0 0 1 0 0", "0,0 0 0 1,5 -INF NaN")), "") << "decimal commas";
  EXPECT_EQ(refusal_of(changed("count=\"2\"", "count=\"9\"")), "") << "looks";
  EXPECT_EQ(refusal_of(changed("<p>0 0 1 0", "<p>0 -1 1 0")), "") << "looks";
  EXPECT_EQ(refusal_of(changed("<translate>1 2 3</translate>", "<rotate>0 0 0 0</rotate>")), "");
  EXPECT_EQ(
      refusal_of(changed("<translate>1 2 3</translate>", "<lookat>0 0 5 1 0 0 0 1 0</lookat>")),
      "");
  EXPECT_EQ(refusal_of(changed("meter=\"1\"", "meter=\"0,01\"")), "");
  EXPECT_EQ(refusal_of(changed("?>", " encoding=\"ISO-8859-1\"?><!-- \xE9 -->")), "");
  EXPECT_EQ(refusal_of(changed("<mesh>", "<!-- <p>-1</p> <matrix>1</matrix> --><mesh>")), "");
}

TEST(ColladaContents, NumbersThatAreNot) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {changed("count=\"9\"", "count=\"1\""),
       "source 's': its accessor reads 9 values of an array that says it has 1"},
      {changed("count=\"3\"", "count=\"4\""),
       "source 's': its accessor reads 12 values of an array that says it has 9"},
      {changed("count=\"3\"", "offset=\"1\" count=\"3\""),
       "source 's': its accessor reads 10 values of an array that says it has 9"},
      {changed("count=\"3\"", "count=\"4294967296\""),
       "<accessor>: count is '4294967296', must be an integer from 0"},
      {changed("<param name=\"Y\"", "<param name=\"X\"/><param name=\"Y\""),
       "source 's': its accessor has 4 params and the stride 3"},
      {changed("<param name=\"Y\"", "<param name=\"W\""),
       "source 's': its accessor has not one X, one Y and one Z, as positions must have"},
      {changed("0 0 0 1 0 0", "0 0 0 1.0.0 0"), "source 's': '1.0.0' is no number"},
      {changed("<p>0 0 1", "<p>0 0 -1"), "geometry 'g': a polygon names vertex -1"},
      {changed("<p>0 0 1", "<p>0 0 4294967295"), "geometry 'g': a polygon names vertex 4294967295"},
      {"<COLLADA>\x1A</COLLADA>", "its byte 9 is a control character, which XML does not have"},
      {changed("<mesh>", "\x90<mesh>"),
       "it is not in UTF-8, as it must be if it does not name another encoding"},
      {changed("<node id=\"n\">", "<translate>1 2 3</translate><node id=\"n\">"),
       "<translate> stands in <visual_scene>, not in a node"},
      {changed("TEXCOORD", "POSITION"), "geometry 'g': it has a second POSITION"},
      {changed("0 0 0 1 0 0", "0 0 0 -99999999999999999999 0 0"),
       "source 's': '-99999999999999999999' has more than 19 digits before its point"},
      {changed("1 2 3", "1 2"), "<translate> has 2 numbers, must have 3"},
      {changed("1 2 3", "1 2 x"), "<translate>: 'x' is no number"},
      {changed("meter=\"1\"", "meter=\"x\""), "its unit is 'x' meters"},
      {changed("meter=\"1\"", "meter=\"0\""), "its unit is '0' meters"},
      {changed("<translate>1 2 3</translate>", "<rotate>0 1 1 90</rotate>"),
       "<rotate> is about an axis of length 1.414, which Assimp takes for 1; export it with "
       "matrices"},
      {changed("<translate>1 2 3</translate>", "<lookat>0 0 5 1 1 0 0 1 0</lookat>"),
       "<lookat> has an up direction that is not square to its line of sight, and Assimp skews by "
       "it; export it with matrices"},
      {changed("0 0 0 1<", "0 0 0 1 1<"), "<matrix> has 17 numbers, must have 16"}};
  for (const auto& [text, wanted] : cases) EXPECT_EQ(refusal_of(text), wanted);
}

TEST(ColladaContents, AreCheckedByTheImport) {
  const tests::TempDir folder;
  const auto import = [&](const std::string& text) {
    const auto scene = import_scene(folder.write("a.dae", text));
    return scene ? "" : scene.error().message;
  };
  EXPECT_EQ(import(kTriangle), "");
  EXPECT_NE(import(changed("<p>0 0 1", "<p>0 0 -1")).find("names vertex -1"), std::string::npos);
}

TEST(XmlTags, AreFoundAmongOtherThings) {
  XmlTags tags("<?xml a='<'?><!DOCTYPE b><!-- <c> --><d e = '>' f=\"1\">g<![CDATA[<h>]]></d ><i/>");
  const auto d = tags.next();
  ASSERT_TRUE(d);
  EXPECT_EQ(d->name, "d");
  EXPECT_EQ(d->attribute("e"), ">");
  EXPECT_EQ(d->attribute("f"), "1");
  EXPECT_EQ(d->attribute("g"), "");
  EXPECT_EQ(d->text, "g");
  const auto end = tags.next();
  ASSERT_TRUE(end);
  EXPECT_TRUE(end->is_end);
  EXPECT_EQ(end->name, "d");
  const auto i = tags.next();
  ASSERT_TRUE(i);
  EXPECT_TRUE(i->is_empty);
  EXPECT_FALSE(tags.next());
  EXPECT_FALSE(XmlTags("<a <!-- x").next());
}

}  // namespace
}  // namespace sightline::client::importer
