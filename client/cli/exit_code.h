// What the command's exit codes mean. Scripts rely on them.
#pragma once

#include "client/result.h"

namespace sightline::client::cli {

enum ExitCode : int {
  kOk = 0,
  kFailed = 1,  ///< Also a local file that cannot be read or written.
  kUsage = 2,
  kNotFound = 3,  ///< A scene or node that the server does not know.
  kConflict = 4,
  kUnavailable = 5,  ///< Or out of time.
  kAuth = 6,
  kResourceLimit = 7,
  kInterrupted = 130,  ///< By Ctrl-C.
};

ExitCode exit_code(Code code);

/// Says on stderr what went wrong, and returns the exit code for it.
ExitCode fail(const Error& error);

/// Says so, and returns kInterrupted.
ExitCode say_interrupted();

/// An error of this machine's files, as kInvalidArgument.
Error local_error(std::string message);

}  // namespace sightline::client::cli
