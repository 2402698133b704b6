// The importer, Assimp and all, on one small file of any content.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace sightline::tests {

enum class FileOutcome : std::uint8_t {
  kTaken,
  kRefused,     ///< With a message.
  kAssimpDied,  ///< Assimp crashed, ran out of memory or took too long, in a process of its own.
};

struct FileReport {
  FileOutcome outcome = FileOutcome::kRefused;
  std::optional<std::string> wrong;  ///< What is wrong with what we made of it.
};

/// The first byte chooses the format, the others are the file. Assimp is a library of others that
/// dies of some damaged files: each is first read in a child process, and if that ends well, here,
/// as the command does it.
FileReport check_file(std::span<const std::uint8_t> bytes);

/// "obj", "glb", ...: the ending of the file's name.
const char* ending_of(std::span<const std::uint8_t> bytes);

}  // namespace sightline::tests
