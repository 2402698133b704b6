// The command line `sightlined doctor`.
#pragma once

namespace sightline::server {

/// Runs `doctor DIR [--repair]`; argv[0] is the verb. Prints a line for each finding and repair.
/// Returns the exit code: 0 if nothing was found, 1 if something was or the directory cannot be
/// examined, kUsageExit.
int run_doctor(int argc, const char* const* argv);

}  // namespace sightline::server
