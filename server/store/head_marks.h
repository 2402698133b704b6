// How far each scene had got, kept beside the database: so it shows when the database goes back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

#include "proto/result.h"
#include "server/net/descriptor.h"
#include "server/store/file_system.h"
#include "server/store/seal.h"

namespace sightline::server::store {

/// The file of marks in a data directory.
std::filesystem::path marks_file(const std::filesystem::path& directory);

/// What a scene's row was when it was committed last.
struct Mark {
  SceneKey scene;
  std::uint64_t edits = 0;     ///< SceneRow::edits at that time.
  std::uint64_t revision = 0;  ///< The newest revision.
};

/// A file of slots of one size. A slot is written in place after the commit and before its callers
/// hear of it, and is not brought to the disk: the process may end at any time, and after a loss of
/// power the file may be behind, which says nothing wrong. When a scene comes or goes, the file is
/// synced. Threads: one at a time.
class HeadMarks {
 public:
  /// Reads the file. It is made by the first write. `files` outlives this object. Errors: those of
  /// FileSystem.
  static Result<HeadMarks> open(FileSystem& files, const std::filesystem::path& path);

  /// Whether the file was there.
  bool found() const { return found_; }
  /// Slots that are neither empty nor match their checksum.
  std::size_t damaged() const { return damaged_; }
  /// The marks by scene.
  const std::map<SceneId, Mark>& all() const { return marks_; }

  /// Errors: those of FileSystem; the mark counts all the same, and sync() writes it again.
  Status set(const Mark& mark);
  Status erase(SceneId scene);
  /// Writes what is not written, and brings all to the disk.
  Status sync();

 private:
  HeadMarks(FileSystem& files, std::filesystem::path path)
      : files_(&files), path_(std::move(path)) {}

  void parse(std::span<const std::byte> bytes);
  Status open_file();
  Status sync_file();
  Status write_slot(std::size_t slot, const Mark& mark);

  FileSystem* files_;
  std::filesystem::path path_;
  net::Descriptor file_;
  bool found_ = false;
  bool behind_ = false;  // a call of the file system has failed
  std::size_t damaged_ = 0;
  std::map<SceneId, Mark> marks_;
  std::map<SceneId, std::size_t> slots_;
  std::vector<std::size_t> free_;
  std::size_t end_ = 0;  // number of slots
};

}  // namespace sightline::server::store
