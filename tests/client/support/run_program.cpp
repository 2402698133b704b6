// Captures output as GoogleTest does.
#include "tests/client/support/run_program.h"

#include <stdlib.h>

#include "client/cli/program.h"

namespace sightline::tests {

ProgramOutcome run_program(const std::vector<std::string>& arguments) {
  std::vector<const char*> words{"sightline"};
  for (const std::string& argument : arguments) words.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int exit = client::cli::run_program(static_cast<int>(words.size()), words.data());
  return {exit, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
}

LiveProgram::LiveProgram() { ::setenv("SIGHTLINE_ENDPOINT", endpoint().c_str(), 1); }
LiveProgram::~LiveProgram() { ::unsetenv("SIGHTLINE_ENDPOINT"); }

}  // namespace sightline::tests
