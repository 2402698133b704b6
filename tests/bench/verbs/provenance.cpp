// The program, machine and date of measurements.
#include "tests/bench/verbs/provenance.h"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <ctime>
#include <fstream>
#include <system_error>
#include <thread>
#include <vector>

#include "tests/support/child_process.h"

namespace sightline::bench {
namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "an unknown processor";
}

std::string compiler() {
#if defined(__clang__)
  return fmt::format("Clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#else
  return fmt::format("GCC {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#endif
}

// The commit of the checkout, or "unknown" if there is no git or no checkout.
std::string git(std::vector<std::string> words) {
  constexpr const char* kGit = "/usr/bin/git";
  words.insert(words.begin(), {"-C", source_folder()});
  try {
    tests::ChildProcess process(kGit, words);
    return process.wait() == 0 ? process.output() : "unknown";
  } catch (const std::system_error&) {
    return "unknown";
  }
}

std::string commit() {
  std::string name = git({"rev-parse", "--short", "HEAD"});
  while (name.ends_with('\n')) name.pop_back();
  if (name == "unknown") return name;
  const bool changed = !git({"status", "--porcelain", "--untracked-files=no"}).empty();
  return name + (changed ? "+" : "");
}

}  // namespace

std::string source_folder() { return SIGHTLINE_SOURCE_FOLDER; }

Provenance provenance() {
  return {fmt::format("{} cores of {}", std::thread::hardware_concurrency(), processor()),
          compiler(), commit(), fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr)))};
}

}  // namespace sightline::bench
