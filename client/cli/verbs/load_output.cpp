// The table of a load test, its document, its page, and the check against an earlier one.
#include "client/cli/verbs/load_output.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "client/cli/files/output.h"
#include "client/cli/reporting.h"
#include "client/cli/terminal.h"
#include "client/load/check.h"
#include "client/load/report/page.h"

namespace sightline::client::cli::verbs {
namespace {

Status write_file(const std::string& path, const std::string& text) {
  auto out = files::Output::open(path);
  if (!out) return out.error();
  if (Status wrote = out->write(text); !wrote) return wrote;
  return out->commit();
}

void print_table(const load::LoadResult& result) {
  fmt::print("{:<8} {:>8} {:>12} {:>9} {:>9} {:>9} {:>9} {:>10} {:>10} {:>7} {:>7}\n", "build",
             "coverage", "rays/s", "p50 ms", "p99 ms", "max ms", "first s", "all rays s",
             "triangles", "failed", "refused");
  for (const load::Row& row : result.rows) {
    const load::Record& record = row.run.record;
    const std::string first =
        record.first_hit ? fmt::format("{:.4f}", load::seconds_of(*record.first_hit - record.begin))
                         : "-";
    const std::string all =
        row.cold && row.run.complete ? fmt::format("{:.3f}", load::duration_s(row)) : "-";
    fmt::print("{:<8} {:>7g}% {:>12} {:>9.3f} {:>9.3f} {:>9.3f} {:>9} {:>10} {:>10} {:>7} {:>7}\n",
               load::name_of(row.build), row.coverage,
               format_count(static_cast<std::uint64_t>(load::rays_per_s(row))),
               load::latency_ms(record.latency, 0.5), load::latency_ms(record.latency, 0.99),
               static_cast<double>(record.latency.max()) * 1e-6, first, all,
               row.growth.empty() ? "-" : format_count(row.growth.back().triangles_built),
               record.failed, record.refused);
  }
  const load::Crossovers crossovers = load::find_crossovers(result.rows);
  if (crossovers.coverage)
    fmt::print("full takes no longer than lazy from {:.0f} % coverage on\n", *crossovers.coverage);
  for (const auto& [coverage, rays] : crossovers.rays) {
    if (rays)
      fmt::print("at {:g} % coverage full has caught up after {} rays\n", coverage,
                 format_count(static_cast<std::uint64_t>(*rays)));
  }
}

/// Adds `regressions` to the result. Returns whether there are any.
Result<bool> check_against(const Json& before, double tolerance, Json& result) {
  const auto found = load::find_regressions(before, result, tolerance);
  if (!found) return found.error();
  Json lines = Json::array();
  for (const load::Regression& regression : *found) {
    const std::string line = load::to_string(regression);
    fmt::print(stderr, "sightline: slower: {}\n", line);
    lines.push_back(line);
  }
  result["regressions"] = std::move(lines);
  return !found->empty();
}

}  // namespace

bool seems_slower(const LoadOutput& output, const load::LoadOptions& options,
                  const load::LoadContext& context, const load::LoadResult& result) {
  if (!output.before || result.interrupted) return false;
  const auto found = load::find_regressions(*output.before, load::to_json(options, context, result),
                                            output.tolerance);
  return found && !found->empty() && load::may_be_noise(*found);
}

ExitCode put_out(const Session& session, const LoadOutput& output, const load::LoadOptions& options,
                 const load::LoadContext& context, const load::LoadResult& result) {
  Json json = load::to_json(options, context, result);
  bool is_slower = false;
  std::optional<Error> error;
  if (output.before && !result.interrupted) {
    const auto checked = check_against(*output.before, output.tolerance, json);
    if (checked) {
      is_slower = *checked;
    } else {
      error = checked.error();
    }
  }
  if (session.json) {
    print_json(json);
  } else {
    print_table(result);
  }
  for (const std::string& warning : result.warnings) print_warning(warning);
  if (!output.page.empty()) {
    const Status wrote = write_file(output.page, load::report::make_page(options, context, result));
    if (!wrote) return fail(wrote.error());
  }
  if (error) return fail(*error);
  if (result.interrupted) return interrupted_code();
  return is_slower ? kFailed : kOk;
}

}  // namespace sightline::client::cli::verbs
