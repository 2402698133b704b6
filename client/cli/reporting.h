// How the command tells of errors and warnings: as text or as JSON, or not at all.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "client/result.h"

namespace sightline::client::cli {

struct Reporting {
  bool json = false;   ///< errors are JSON objects, one a line
  bool quiet = false;  ///< no progress, no summaries, no warnings
  /// What to do about an error, or what may have been meant; may be empty. May ask the server.
  std::function<std::string(const Error&)> hint = {};
};

/// While it exists, errors and warnings are told so. One at a time, on the main thread.
class ReportingScope {
 public:
  explicit ReportingScope(Reporting reporting);
  ReportingScope(const ReportingScope&) = delete;
  ReportingScope& operator=(const ReportingScope&) = delete;
  ~ReportingScope();
};

bool is_quiet();

/// Prints an error on stderr, with its hint.
void print_error(const Error& error, int exit);

/// Prints an error of the command line on stderr. `hint` may be empty.
void print_usage_error(std::string_view message, std::string_view hint, int exit);

void print_warning(std::string_view warning);

/// Whether escape sequences may go to stderr: it is a terminal, and not a dumb one.
bool is_stderr_a_terminal();

}  // namespace sightline::client::cli
