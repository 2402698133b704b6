// The importer, including Assimp, on one small file with any content.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace sightline::tests {

enum class FileOutcome : std::uint8_t {
  kTaken,
  kRefused,     ///< With a message.
  kAssimpDied,  ///< Assimp crashed, ran out of memory or took too long, in a separate process.
};

struct FileReport {
  FileOutcome outcome = FileOutcome::kRefused;
  std::optional<std::string> wrong;  ///< The error in the imported scene.
};

/// The first byte selects the format, the others are the file. Assimp is a third-party library that
/// crashes on some damaged files: each file is first read in a child process, and if that succeeds,
/// in this process, where the fuzzer sees what the importer does.
FileReport check_file(std::span<const std::uint8_t> bytes);

/// "obj", "glb", ...: the file name's extension.
const char* ending_of(std::span<const std::uint8_t> bytes);

}  // namespace sightline::tests
