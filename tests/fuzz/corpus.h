// The stored inputs of a fuzzer.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace sightline::tests {

struct KeptInput {
  std::string name;
  std::vector<std::uint8_t> bytes;
};

/// All files in tests/fuzz/corpus/`fuzzer`, by name.
inline std::vector<KeptInput> kept_inputs(const std::string& fuzzer) {
  std::vector<KeptInput> inputs;
  const std::filesystem::path folder = std::filesystem::path(SIGHTLINE_FUZZ_CORPUS) / fuzzer;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::vector<char> text(std::istreambuf_iterator<char>(in), {});
    inputs.push_back({entry.path().filename().string(), {text.begin(), text.end()}});
  }
  std::sort(inputs.begin(), inputs.end(),
            [](const KeptInput& a, const KeptInput& b) { return a.name < b.name; });
  return inputs;
}

}  // namespace sightline::tests
