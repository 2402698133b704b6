// libFuzzer target: the importer on files. Built and run by tests/fuzz/run. Files on which Assimp
// crashes are not findings; the first ones are kept in the folder SIGHTLINE_FUZZ_ASSIMP.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <ios>
#include <span>
#include <string>

#include "tests/fuzz/importer/check_file.h"

namespace {

using namespace sightline::tests;

constexpr int kFilesKept = 200;

void keep(std::span<const std::uint8_t> bytes) {
  static int kept = 0;
  const char* const folder = std::getenv("SIGHTLINE_FUZZ_ASSIMP");
  if (folder == nullptr || bytes.empty() || kept == kFilesKept) return;
  const std::string name = "died-" + std::to_string(kept++) + "." + ending_of(bytes);
  std::ofstream out(std::filesystem::path(folder) / name, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()) + 1,
            static_cast<std::streamsize>(bytes.size() - 1));
}

}  // namespace

// A file of a few bytes must not make Assimp allocate all memory; and Assimp leaks what it refuses.
extern "C" const char* __asan_default_options() {
  return "max_allocation_size_mb=1024:detect_leaks=0";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const FileReport report = check_file({data, size});
  if (report.outcome == FileOutcome::kAssimpDied) keep({data, size});
  if (!report.wrong) return 0;
  std::fprintf(stderr, "imported: %s\n", report.wrong->c_str());
  std::abort();
}
