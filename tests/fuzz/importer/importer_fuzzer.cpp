// libFuzzer target: the importer after Assimp, on scenes in Assimp's form. Built and run by
// tests/fuzz/run.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/importer/check_made.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto wrong = sightline::tests::check_made({data, size});
  if (!wrong) return 0;
  std::fprintf(stderr, "imported: %s\n", wrong->c_str());
  std::abort();
}
