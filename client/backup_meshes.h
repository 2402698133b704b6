// The meshes of a backup: a file each, named for its sum, so that the next backup can share it.
// Internal to the library.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/result.h"
#include "client/sha256.h"
#include "sightline/v1/backup.pb.h"

namespace sightline::client {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// The folder of the meshes in the directory of a backup.
inline constexpr const char* kMeshFolder = "meshes";

/// The bytes of each mesh of a backup, by its SHA-256 in hex, which is the name of its file.
using MeshSizes = std::map<std::string, std::uint64_t>;

/// The error of a backup whose file is not what was written.
Error not_whole(const std::filesystem::path& path);

/// An error of the system about a file.
Error file_error(const std::filesystem::path& path, int error);

/// Writes meshes as they come, and links those that an earlier backup has.
class BackupMeshWriter {
 public:
  /// `directory` and `since` are backups; `earlier` are the meshes of `since`, which are as they
  /// were written.
  BackupMeshWriter(std::filesystem::path directory, std::filesystem::path since, MeshSizes earlier);

  /// The digests of meshes that the server need not send: the largest, as many as a request takes.
  std::vector<std::string> known() const;
  /// Takes the next piece of a mesh, or the digest alone of one that is known. Errors:
  /// kInvalidArgument, of the system; kDataLoss, pieces that do not make the mesh.
  Status add(const v1::BackupMesh& piece);
  /// The sums of the files, and whether the last one is whole.
  const std::set<std::string>& sums() const { return sums_; }
  bool is_whole() const { return file_ == nullptr && !linking_; }

 private:
  Status begin();
  Status end();
  Status link();
  std::filesystem::path path() const { return directory_ / kMeshFolder / sum_; }

  std::filesystem::path directory_, since_;
  MeshSizes earlier_;
  std::set<std::string> sums_;
  // The mesh that comes:
  std::string digest_, sum_;
  std::uint64_t size_ = 0, taken_ = 0;
  bool linking_ = false;
  File file_;
  Sha256 hash_;
};

/// Reads meshes in pieces of the size that a server takes.
class BackupMeshReader {
 public:
  explicit BackupMeshReader(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// Begins with the mesh of this digest. Errors: kDataLoss, there is none of its size.
  Status begin(const std::string& digest);
  bool is_reading() const { return file_ != nullptr; }
  /// The next piece. Errors: kDataLoss.
  Status next(v1::BackupMesh& piece);

 private:
  std::filesystem::path directory_, path_;
  std::string digest_;
  std::uint64_t rest_ = 0;
  File file_;
};

/// The sum in hex and the bytes of a digest "sha256:HEX/BYTES". Errors: kDataLoss, another text.
Result<std::pair<std::string, std::uint64_t>> parse_mesh_digest(const std::string& text);

}  // namespace sightline::client
