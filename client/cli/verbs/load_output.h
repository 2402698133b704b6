// What `sightline load` prints and writes.
#pragma once

#include <optional>
#include <string>

#include "client/cli/session.h"
#include "client/load/load_test.h"
#include "client/load/result_json.h"

namespace sightline::client::cli::verbs {

struct LoadOutput {
  std::string page;            ///< a file for the report; empty: none
  std::optional<Json> before;  ///< an earlier document to check against
  double tolerance = 0;
};

/// Whether the result is slower than the earlier document, and another run may not be.
bool seems_slower(const LoadOutput& output, const load::LoadOptions& options,
                  const load::LoadContext& context, const load::LoadResult& result);

/// Prints the table or the document on stdout, warnings and regressions on stderr, and writes the
/// page. Returns the exit code of the command: kFailed also for a regression.
ExitCode put_out(const Session& session, const LoadOutput& output, const load::LoadOptions& options,
                 const load::LoadContext& context, const load::LoadResult& result);

}  // namespace sightline::client::cli::verbs
