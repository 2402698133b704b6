// The calls of the system that a store makes, behind an interface.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/net/descriptor.h"

namespace sightline::server::store {

/// The content of a file, mapped for reading as long as the object lives.
class MappedFile {
 public:
  virtual ~MappedFile() = default;
  virtual std::span<const std::byte> bytes() const = 0;
};

/// A file of a directory.
struct FileEntry {
  std::filesystem::path path;
  std::uint64_t size = 0;
  std::chrono::system_clock::time_point written;
};

/// Errors of every member: those of file_error(), unless they are named. Threads: any.
class FileSystem {
 public:
  using Path = std::filesystem::path;

  virtual ~FileSystem() = default;

  /// Creates the directory, whose parent exists. One that exists is success.
  virtual Status make_directory(const Path& directory) = 0;
  /// Opens a new file for writing. One of this name is emptied.
  virtual Result<net::Descriptor> create(const Path& file) = 0;
  /// Writes all the bytes at the end of what was written. `path`: for errors, as below.
  virtual Status write(const net::Descriptor& file, std::span<const std::byte> bytes,
                       const Path& path) = 0;
  /// Opens a file for writing in place. It is made if it is missing.
  virtual Result<net::Descriptor> open(const Path& file) = 0;
  /// Writes all the bytes at an offset.
  virtual Status write_at(const net::Descriptor& file, std::span<const std::byte> bytes,
                          std::uint64_t offset, const Path& path) = 0;
  /// Returns when what was written is on disk.
  virtual Status sync(const net::Descriptor& file, const Path& path) = 0;
  /// Returns when the names in the directory are on disk.
  virtual Status sync_directory(const Path& directory) = 0;
  /// Renames the file, and replaces `to`.
  virtual Status rename(const Path& from, const Path& to) = 0;
  /// Removes the file. One that does not exist is success.
  virtual Status remove(const Path& file) = 0;
  /// Errors: also kNotFound.
  virtual Result<std::unique_ptr<MappedFile>> map(const Path& file) = 0;
  /// The regular files of a directory by name, without those of directories in it; none if it does
  /// not exist.
  virtual Result<std::vector<FileEntry>> list(const Path& directory) = 0;
  virtual bool exists(const Path& file) = 0;
  /// Takes the file, made if it is missing, for this process until the descriptor is closed.
  /// Errors: also kAlreadyExists, if another holds it.
  virtual Result<net::Descriptor> lock(const Path& file) = 0;
  /// Bytes that the directory's file system has left for this process.
  virtual Result<std::uint64_t> bytes_free(const Path& directory) = 0;
  /// The name of the network file system that the directory is on; empty: it is none.
  virtual Result<std::string> network(const Path& directory) = 0;

  /// The VFS of SQLite through which a database is used. Null: its default.
  virtual const char* database_vfs() const { return nullptr; }
};

/// The file system of this machine. Lives as long as the process.
FileSystem& local_files();

}  // namespace sightline::server::store
