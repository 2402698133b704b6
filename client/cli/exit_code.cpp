// Errors to exit codes.
#include "client/cli/exit_code.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

namespace sightline::client::cli {

ExitCode exit_code(Code code) {
  switch (code) {
    case Code::kNotFound:
      return kNotFound;
    case Code::kAlreadyExists:
    case Code::kFailedPrecondition:
    case Code::kAborted:
      return kConflict;
    case Code::kUnavailable:
    case Code::kDeadlineExceeded:
      return kUnavailable;
    case Code::kUnauthenticated:
    case Code::kPermissionDenied:
      return kAuth;
    case Code::kResourceExhausted:
      return kResourceLimit;
    default:
      return kFailed;
  }
}

ExitCode fail(const Error& error) {
  const char* what = error.code == Code::kUnavailable        ? "server not available: "
                     : error.code == Code::kDeadlineExceeded ? "out of time: "
                                                             : "";
  fmt::print(stderr, "sightline: {}{}\n", what, error.message.empty() ? "failed" : error.message);
  return exit_code(error.code);
}

ExitCode say_interrupted() {
  fmt::print(stderr, "sightline: interrupted\n");
  return kInterrupted;
}

Error local_error(std::string message) { return {Code::kInvalidArgument, std::move(message), {}}; }

}  // namespace sightline::client::cli
