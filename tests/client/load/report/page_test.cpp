// The page of a result that is made here: sections, sentences, and nothing from elsewhere.
#include "client/load/report/page.h"

#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <string>
#include <vector>

namespace sightline::client::load::report {
namespace {

using std::chrono::milliseconds;

constexpr std::uint64_t kRays = 1'000'000;

/// Answers in even steps after a time without any.
Row cold_row(BuildMode build, double coverage, int build_ms, int step_ms) {
  Row row;
  row.build = build;
  row.coverage = coverage;
  row.cold = true;
  for (int i = 1; i <= 100; ++i) {
    Outcome outcome;
    outcome.rays = kRays / 100;
    outcome.hits = 1;
    outcome.trace_us = 500;
    const Nanoseconds done = milliseconds(build_ms + step_ms * i);
    add_to(row.run.record, {done - milliseconds(step_ms), done - milliseconds(step_ms), done},
           outcome, milliseconds(100));
  }
  row.growth = {{milliseconds(0), 0, 0}, {milliseconds(500), 40'000, 4'000'000}};
  return row;
}

/// Answers so that all rays have taken this many seconds.
Row row_of(BuildMode build, double coverage, double seconds) {
  return cold_row(build, coverage, 0, static_cast<int>(seconds * 10));
}

LoadOptions options() {
  LoadOptions made;
  made.compare = {BuildMode::kLazy, BuildMode::kFull};
  made.coverage = {1, 100};
  made.rays_per_run = kRays;
  return made;
}

LoadResult result() {
  LoadResult made;
  made.scene.name = "projects/default/scenes/hall<1>";
  made.server.threads = 2;
  made.triangles_total = 100'000;
  made.rows = {cold_row(BuildMode::kLazy, 1, 5, 4), cold_row(BuildMode::kFull, 1, 500, 3),
               cold_row(BuildMode::kLazy, 100, 5, 10), cold_row(BuildMode::kFull, 100, 500, 3)};
  return made;
}

LoadContext context() {
  return {.rays = "overview",
          .command = "sightline load hall --rays 'a & b'",
          .client_version = "1",
          .machine = {}};
}

TEST(ReportPage, HasTheSectionsOfAComparison) {
  const std::string page = make_page(options(), context(), result());
  for (const char* title :
       {"by how much of the scene is touched", "by the number of rays", "Latency", "Throughput",
        "Triangles built over time", "Memory of the trees over time", "Where time went",
        "How this was measured"})
    EXPECT_NE(page.find(title), std::string::npos) << title;
}

TEST(ReportPage, SaysWhereTheCrossoverIs) {
  const std::string page = make_page(options(), context(), result());
  // At 100 %: 1.05 (5 + 10 n) ms against 500 + 3 n ms, for n hundredths of the rays.
  EXPECT_NE(page.find("After 660 k rays, building everything first has caught up"),
            std::string::npos);
  EXPECT_NE(page.find("crossover: 660 k rays"), std::string::npos);
  EXPECT_NE(page.find("crossover: 60 %"), std::string::npos);
}

/// What is said of runs that took these seconds, lazy and full, by coverage; 0: not measured.
std::string verdict_of(const std::vector<std::array<double, 3>>& runs) {
  LoadOptions asked = options();
  LoadResult made = result();
  asked.coverage.clear();
  made.rows.clear();
  for (const auto& [coverage, lazy, full] : runs) {
    asked.coverage.push_back(coverage);
    if (lazy > 0) made.rows.push_back(row_of(BuildMode::kLazy, coverage, lazy));
    if (full > 0) made.rows.push_back(row_of(BuildMode::kFull, coverage, full));
  }
  const std::string page = make_page(asked, context(), made);
  const std::size_t begin = page.find("by how much of the scene is touched");
  return begin == std::string::npos ? "" : page.substr(begin, page.find("</p>", begin) - begin);
}

TEST(ReportPage, SaysWhoIsAheadAndWhere) {
  struct Case {
    std::vector<std::array<double, 3>> runs;
    const char* text;
  };
  const std::array cases = std::to_array<Case>({
      {{{1, 1, 2}, {10, 2, 3}, {100, 3, 4}}, "on demand is ahead at every share"},
      {{{1, 2, 1}, {10, 3, 2}, {100, 4, 3}}, "everything first is ahead at every share"},
      {{{1, 2, 2}, {10, 3, 3.1}, {100, 4, 3.9}}, "about as long at every share"},
      {{{1, 1, 2}, {10, 2, 2}, {100, 4, 3}}, "on, building everything first takes no longer"},
      {{{1, 2, 1}, {10, 2, 2}, {100, 3, 3}}, "everything first takes no longer at every share"},
      {{{1, 2, 2}, {10, 2, 2}, {100, 3, 4}}, "on demand takes no longer at every share"},
      {{{1, 2, 1}, {10, 2, 3}, {100, 3, 4}}, "ahead at 10 % and 100 %, and behind at 1 %"},
      {{{1, 1, 2}, {10, 3, 2}, {100, 3, 4}}, "ahead at 1 % and 100 %, and behind at 10 %"},
      {{{1, 1, 0}, {10, 2, 3}, {100, 0, 4}, {50, 2, 3}}, "on demand is ahead at every share"},
      {{{1, 1, 0}, {10, 2, 0}, {50, 0, 3}, {100, 0, 4}}, "not measured at the same shares"},
  });
  for (const auto& [runs, text] : cases) {
    const std::string said = verdict_of(runs);
    EXPECT_NE(said.find(text), std::string::npos) << text << "\n" << said;
  }
  EXPECT_EQ(verdict_of({{100, 1, 2}}), "");
}

TEST(ReportPage, ARunWithoutAnswersAtTheLargestCoverageIsLeftOut) {
  LoadResult made = result();
  made.rows[2].run.record = {};
  made.rows[3].run.record = {};
  EXPECT_NE(make_page(options(), context(), made).find("Where time went"), std::string::npos);
}

TEST(ReportPage, LoadsNothingAndRunsNothing) {
  const std::string page = make_page(options(), context(), result());
  for (const char* foreign : {"http", "<script", "<link", "<img", "@import", "url(", "src="})
    EXPECT_EQ(page.find(foreign), std::string::npos) << foreign;
}

TEST(ReportPage, EscapesNamesAndTheCommand) {
  const std::string page = make_page(options(), context(), result());
  EXPECT_EQ(page.find("hall<1>"), std::string::npos);
  EXPECT_NE(page.find("hall&lt;1&gt;"), std::string::npos);
  EXPECT_NE(page.find("'a &amp; b'"), std::string::npos);
}

// Each element is closed by the one that opened it last.
TEST(ReportPage, IsWellFormed) {
  const std::string page = make_page(options(), context(), result());
  std::vector<std::string> open;
  for (std::size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
    const std::size_t end = page.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const bool is_end = page[at + 1] == '/', is_empty = page[end - 1] == '/';
    std::string name;
    for (std::size_t i = at + 1 + (is_end ? 1 : 0);
         i < end && std::isspace(static_cast<unsigned char>(page[i])) == 0 && page[i] != '/'; ++i)
      name += page[i];
    if (name == "!doctype" || name == "meta" || is_empty) continue;
    if (!is_end) {
      open.push_back(name);
      continue;
    }
    ASSERT_FALSE(open.empty());
    EXPECT_EQ(open.back(), name);
    open.pop_back();
  }
  EXPECT_TRUE(open.empty());
}

TEST(ReportPage, OfAWarmRunHasLatencyOverTime) {
  LoadResult warm = result();
  Row row;
  for (int i = 0; i < 400; ++i) {
    Outcome outcome;
    outcome.rays = 8192;
    // A second without answers
    const Nanoseconds due = milliseconds(10 * i);
    const Nanoseconds done = milliseconds(i >= 200 && i < 300 ? 3000 : 10 * i + 5);
    add_to(row.run.record, {due, due, done}, outcome, std::chrono::seconds(1));
  }
  warm.rows = {row};
  LoadOptions asked;
  asked.rate = 100;
  const std::string page = make_page(asked, context(), warm);
  EXPECT_NE(page.find("The slowest took 1 s, 200 times that"), std::string::npos);
  EXPECT_EQ(page.find("Lazy against full"), std::string::npos);
}

TEST(ReportPage, OfARunWithoutAnswersSaysSo) {
  LoadResult none = result();
  none.rows = {Row()};
  none.warnings = {"12 requests failed"};
  const std::string page = make_page(LoadOptions(), context(), none);
  EXPECT_NE(page.find("12 requests failed"), std::string::npos);
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace sightline::client::load::report
