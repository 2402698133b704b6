// Errors and warnings as text and as JSON.
#include "client/cli/reporting.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "client/cli/terminal.h"

namespace sightline::client::cli {
namespace {

template <class Print>
std::string printed(const Reporting& reporting, Print print) {
  const ReportingScope scope(reporting);
  testing::internal::CaptureStderr();
  print();
  return testing::internal::GetCapturedStderr();
}

const Error kLostServer{Code::kUnavailable, "no\x1b[31m way", "GONE"};

TEST(Reporting, TextHasTheHintBehindTheError) {
  EXPECT_EQ(printed({}, [] { fail(kLostServer); }),
            "sightline: server not available: no\\x1b[31m way\n");
  EXPECT_EQ(printed({.hint = [](const Error&) { return "try again"; }}, [] { fail(kLostServer); }),
            "sightline: server not available: no\\x1b[31m way; try again\n");
}

TEST(Reporting, JsonIsOneLine) {
  const std::string text = printed({.json = true, .hint = [](const Error&) { return "again"; }},
                                   [] { fail(kLostServer); });
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  const auto error = nlohmann::json::parse(text)["error"];
  EXPECT_EQ(error["code"], "UNAVAILABLE");
  EXPECT_EQ(error["reason"], "GONE");
  EXPECT_EQ(error["hint"], "again");
  EXPECT_EQ(error["exit"], 5);
  const auto usage = nlohmann::json::parse(
      printed({.json = true}, [] { print_usage_error("what?", "this", kUsage); }))["error"];
  EXPECT_EQ(usage["code"], "USAGE");
  EXPECT_EQ(usage["message"], "what?");
}

TEST(Reporting, QuietIsWithoutWarningsButWithErrors) {
  EXPECT_EQ(printed({}, [] { print_warning("hm"); }), "sightline: warning: hm\n");
  EXPECT_EQ(printed({.quiet = true}, [] { print_warning("hm"); }), "");
  EXPECT_NE(printed({.quiet = true}, [] { fail(kLostServer); }), "");
}

}  // namespace
}  // namespace sightline::client::cli
