// libFuzzer target: the public port. Built and run by tests/fuzz/run.
#include <grpc/support/log.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>

#include "tests/fuzz/port/check_port.h"

/// Without gRPC's line for every connection with an error.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  gpr_set_log_function([](gpr_log_func_args*) {});
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto wrong = sightline::tests::check_port(std::span(data, size));
  if (!wrong) return 0;
  std::fprintf(stderr, "port: %s\n", wrong->c_str());
  std::abort();
}
