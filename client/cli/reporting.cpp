// Prints on stderr only: stdout is for data.
#include "client/cli/reporting.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

#include "client/cli/session.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli {
namespace {

Reporting current;

// Reads the environment, which no thread of the command changes.
bool is_set(const char* name) {
  const char* const value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr && *value != '\0';
}

std::string coloured(const char* text, const char* colour) {
  const bool plain = is_set("NO_COLOR") || !is_stderr_a_terminal();
  return plain ? text : fmt::format("\x1b[{}m{}\x1b[0m", colour, text);
}

constexpr const char* kRed = "1;31";
constexpr const char* kYellow = "1;33";

// What the library says of a connection that failed, without the words that repeat themselves.
std::string shortened(const std::string& message) {
  constexpr std::string_view kMany = "failed to connect to all addresses";
  if (!message.starts_with(kMany)) return message;
  const std::size_t last = message.rfind(": ");
  return last == std::string::npos ? message : message.substr(last + 2);
}

std::string text_of(const Error& error) {
  const char* const what = error.code == Code::kUnavailable        ? "server not available: "
                           : error.code == Code::kDeadlineExceeded ? "out of time: "
                                                                   : "";
  return what + (error.message.empty() ? "failed" : printable(shortened(error.message)));
}

void print_json_error(Json error) {
  fmt::print(stderr, "{}\n", json_text({{"error", std::move(error)}}, -1));
}

}  // namespace

ReportingScope::ReportingScope(Reporting reporting) { current = std::move(reporting); }
ReportingScope::~ReportingScope() { current = {}; }

bool is_quiet() { return current.quiet; }

bool is_stderr_a_terminal() {
  const char* const term = std::getenv("TERM");  // NOLINT(concurrency-mt-unsafe)
  return ::isatty(STDERR_FILENO) == 1 && (term == nullptr || std::string_view(term) != "dumb");
}

void print_error(const Error& error, int exit) {
  const std::string hint = current.hint ? printable(current.hint(error)) : "";
  if (current.json) {
    print_json_error({{"code", name_of(error.code)},
                      {"reason", error.reason},
                      {"message", text_of(error)},
                      {"hint", hint},
                      {"exit", exit}});
    return;
  }
  fmt::print(stderr, "{} {}{}{}\n", coloured("sightline:", kRed), text_of(error),
             hint.empty() ? "" : "; ", hint);
}

void print_usage_error(std::string_view message, std::string_view hint, int exit) {
  if (current.json) {
    print_json_error({{"code", "USAGE"},
                      {"reason", ""},
                      {"message", printable(message)},
                      {"hint", printable(hint)},
                      {"exit", exit}});
    return;
  }
  fmt::print(stderr, "{} {}{}{}\n", coloured("sightline:", kRed), printable(message),
             hint.empty() ? "" : "; ", printable(hint));
}

void print_warning(std::string_view warning) {
  if (current.quiet) return;
  fmt::print(stderr, "{} warning: {}\n", coloured("sightline:", kYellow), printable(warning));
}

}  // namespace sightline::client::cli
