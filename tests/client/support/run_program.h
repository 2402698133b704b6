// Runs the command in this process and captures its output.
#pragma once

#include <string>
#include <vector>

#include "tests/client/support/live_client.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::tests {

struct ProgramOutcome {
  int exit = 0;
  std::string out;
  std::string err;
};

ProgramOutcome run_program(const std::vector<std::string>& arguments);

/// With a server, which the command finds through SIGHTLINE_ENDPOINT, and a folder.
class LiveProgram : public LiveClient {
 protected:
  LiveProgram();
  ~LiveProgram() override;

  TempDir dir_;
};

}  // namespace sightline::tests
