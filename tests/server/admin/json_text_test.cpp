// Which texts are taken as JSON.
#include "server/admin/json_text.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::server::admin {
namespace {

std::string nested(std::size_t depth) {
  std::string text;
  for (std::size_t i = 0; i < depth; ++i) text += R"({"a":)";
  return text + "1" + std::string(depth, '}');
}

TEST(JsonText, TakesOneObject) {
  for (const char* text :
       {"{}", " {\"a\": [1, -2.5e3, null, true, \"\\u00e4\"], \"b\": {\"a\": 1}}\n", R"([])",
        R"(1)", R"("{}")", "", "{} {}", "{}x", "\xEF\xBB\xBF"}) {
    const bool is_object = text[0] == '{' || text[0] == ' ';
    const bool is_one = std::string(text) != "{} {}" && std::string(text) != "{}x";
    EXPECT_EQ(bool(check_json(text)), is_object && is_one) << text;
  }
}

TEST(JsonText, RefusesWhatOnlyLooksLikeJson) {
  for (const char* text : {"{'a': 1}", "{a: 1}", "{\"a\": 1,}", "{\"a\": 01}", "{\"a\": NaN}",
                           "{\"a\": .5}", "{\"a\": 1 // one\n}", "{\"a\": \"\xff\"}",
                           "{\"a\": \"\\ud800\"}", "{\"a\": \"\n\"}", "{\"a\"}", "{"}) {
    const Status checked = check_json(text);
    ASSERT_FALSE(checked) << text;
    EXPECT_EQ(checked.error().code, Code::kInvalidArgument);
    EXPECT_EQ(checked.error().reason, "BAD_JSON");
  }
}

TEST(JsonText, ANameStandsOnceInAnObject) {
  EXPECT_TRUE(check_json(R"({"a": {"b": 1}, "c": [{"b": 1}, {"b": 2}], "b": 1})"));
  EXPECT_FALSE(check_json(R"({"a": 1, "a": 2})"));
  EXPECT_FALSE(check_json(R"({"a": [{"b": 1, "c": 2, "b": 3}]})"));
  EXPECT_FALSE(check_json(R"({"upAxis": 1, "up_axis": 2})")) << "messages take both";
  EXPECT_FALSE(check_json(R"({"a": 1, "\u0061": 2})"));
}

TEST(JsonText, IsNestedNoDeeperThanTheLimit) {
  EXPECT_TRUE(check_json(nested(kMaxJsonDepth)));
  EXPECT_FALSE(check_json(nested(kMaxJsonDepth + 1)));
  EXPECT_FALSE(check_json(R"({"a": )" + std::string(100'000, '[')));
}

}  // namespace
}  // namespace sightline::server::admin
