// The folder of a scene file: opens regular files below it, and nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/importer/sandbox/allowance.h"
#include "client/importer/sandbox/file_handle.h"
#include "client/result.h"

namespace sightline::client::importer::sandbox {

/// The error "FILE: why", as kInvalidArgument.
Error file_error(const std::filesystem::path& file, const std::string& why);

/// Opens a regular file for reading; symbolic links are followed. Errors: kInvalidArgument, with
/// the path and what is wrong: the system's message, or that it is a directory, a pipe, a device or
/// a socket. Never blocks and never touches a device.
Result<FileHandle> open_regular(const std::filesystem::path& file);

struct OpenedFile {
  FileHandle handle;
  std::uint64_t bytes = 0;   ///< its size, holes included
  std::uint64_t number = 0;  ///< the file's number, whatever its name
};

/// What a scene file may read: itself, and regular files in its folder and the folders below.
/// Symbolic links are followed as long as they stay there.
class SceneFolder {
 public:
  /// Opens the scene file itself, at any path. `memory`: what its reader may use. Errors: those of
  /// open_regular.
  static Result<SceneFolder> open(const std::filesystem::path& file, const Allowance& memory);

  /// Opens a file by its path relative to the folder. Nothing: it does not exist, is not regular,
  /// is not below the folder, or has so large a hole that all files together, holes included, are
  /// larger than the memory which their stored bytes allow.
  std::optional<OpenedFile> open_file(const std::string& name);

  /// Stored bytes of all different files that were opened. Holes buy nothing.
  std::uint64_t bytes() const { return bytes_; }
  /// Why files were refused, apart from those that do not exist; the first few.
  const std::vector<std::string>& refusals() const { return refusals_; }

 private:
  SceneFolder(std::string name, FileHandle folder, FileHandle scene, const Allowance& memory)
      : name_(std::move(name)),
        folder_(std::move(folder)),
        scene_(std::move(scene)),
        memory_(memory) {}
  std::optional<OpenedFile> measured(const std::string& name, FileHandle file);
  void refuse(const std::string& name, std::string_view why);

  std::string name_;
  FileHandle folder_, scene_;
  Allowance memory_;
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint64_t> seen_;  // device, inode: number
  std::uint64_t bytes_ = 0;
  std::uint64_t sizes_ = 0;  // sizes of these files, holes included
  std::vector<std::string> refusals_;
};

}  // namespace sightline::client::importer::sandbox
