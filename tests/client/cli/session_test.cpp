// JSON for programs that is also shown on terminals.
#include "client/cli/session.h"

#include <gtest/gtest.h>

namespace sightline::client::cli {
namespace {

TEST(JsonText, EscapesAllControlCharacters) {
  const Json document{{"name", "a\x1b[2J\x7f\xc2\x80\xc2\x9b[31m\xc3\xa4"}};
  const std::string text = json_text(document, -1);
  EXPECT_EQ(text, "{\"name\":\"a\\u001b[2J\\u007f\\u0080\\u009b[31m\xc3\xa4\"}");
  EXPECT_EQ(Json::parse(text), document);
}

}  // namespace
}  // namespace sightline::client::cli
