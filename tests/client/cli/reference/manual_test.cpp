// The pages say what --help says.
#include "client/cli/reference/manual.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>

#include "client/cli/program.h"
#include "client/cli/session.h"

namespace sightline::client::cli::reference {
namespace {

/// Roff without its escapes.
std::string plain(std::string text) {
  const auto drop = [&text](const std::string& what, const std::string& instead) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos;)
      text.replace(at, what.size(), instead);
  };
  for (const char* escape : {"\\fB", "\\fI", "\\fR", "\\&"}) drop(escape, "");
  drop("\\-", "-");
  return text;
}

class Manual : public testing::Test {
 protected:
  const ManualPage& page(const std::string& file) const {
    const auto found = std::find_if(pages_.begin(), pages_.end(),
                                    [&file](const ManualPage& page) { return page.file == file; });
    EXPECT_NE(found, pages_.end()) << file;
    return found == pages_.end() ? pages_.front() : *found;
  }

  Session session_;
  std::unique_ptr<CLI::App> program_ = make_program(session_);
  std::vector<ManualPage> pages_ = manual_of(*program_, 1, "sightline 1.2.3");
};

TEST_F(Manual, HasAPageForEveryVerb) {
  std::size_t verbs = 1;
  for (const CLI::App* verb : program_->get_subcommands([](const CLI::App*) { return true; }))
    verbs += 1 + verb->get_subcommands([](const CLI::App*) { return true; }).size();
  EXPECT_EQ(pages_.size(), verbs);
  EXPECT_EQ(pages_.front().file, "sightline.1");
  EXPECT_NE(page("sightline-scene-import.1").text.find(".TH SIGHTLINE\\-SCENE\\-IMPORT 1"),
            std::string::npos);
}

TEST_F(Manual, HasTheTextOfEveryOption) {
  const CLI::App* const cast = program_->get_subcommand("cast");
  const std::string text = plain(page("sightline-cast.1").text);
  EXPECT_NE(text.find(cast->get_description()), std::string::npos);
  for (const CLI::Option* option : cast->get_options()) {
    EXPECT_NE(text.find(option->get_description()), std::string::npos) << option->get_name();
    for (const std::string& name : option->get_lnames())
      EXPECT_NE(text.find("--" + name), std::string::npos) << name;
  }
}

TEST_F(Manual, HasTheFooterWithItsExamples) {
  const std::string text = plain(page("sightline.1").text);
  EXPECT_NE(text.find("Exit codes: 0 ok"), std::string::npos);
  EXPECT_NE(text.find(".SH EXAMPLES\n.nf\n  sightline scene import"), std::string::npos);
  EXPECT_NE(text.find("sightline 1.2.3"), std::string::npos);
  EXPECT_NE(text.find("sightline-scene(1)"), std::string::npos);
}

TEST_F(Manual, TextThatMeansSomethingToRoffIsEscaped) {
  CLI::App app("A back\\slash", "odd");
  app.footer(".SH Not a title\n'quoted' first\nAn a-b word");
  const std::string text = manual_of(app, 1, "odd").front().text;
  EXPECT_NE(text.find("A back\\eslash"), std::string::npos);
  EXPECT_NE(text.find("\\&.SH Not a title\n\\&'quoted' first\nAn a\\-b word"), std::string::npos);
}

}  // namespace
}  // namespace sightline::client::cli::reference
