// The files of a backup: parts, each after its length in 4 bytes, least significant first; sums;
// and meshes beside them.
#include "client/backup_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

namespace sightline::client {
namespace {

namespace fs = std::filesystem;

constexpr const char* kParts = "scenes.parts";
constexpr const char* kIncomplete = "incomplete";
/// The file of sums, in the form of sha256sum.
constexpr const char* kSums = "SHA256SUMS";
/// A part is a message of the API, which is smaller.
constexpr std::uint32_t kLargestPart = std::uint32_t{64} << 20;

std::string sums_line(const std::string& sum, const std::string& name) {
  return fmt::format("{}  {}\n", sum, name);
}

std::string mesh_name(const std::string& sum) { return fmt::format("{}/{}", kMeshFolder, sum); }

Status sync(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return file_error(path, errno);
  const int error = fsync(file) == 0 ? 0 : errno;
  close(file);
  return error == 0 ? Status() : Status(file_error(path, error));
}

/// Writes all files of the file system to the disk at once: a backup may have a hundred thousand.
Status sync_all(std::FILE* file, const fs::path& path) {
  const int number = fileno(file);
  if (syncfs(number) == 0 && fsync(number) == 0) return {};
  return file_error(path, errno);
}

Status write_file(const fs::path& path, const std::string& text) {
  const File file(std::fopen(path.c_str(), "wxe"));
  if (!file) return file_error(path, errno);
  if (std::fwrite(text.data(), 1, text.size(), file.get()) != text.size() ||
      std::fflush(file.get()) != 0)
    return file_error(path, errno);
  return sync(path);
}

/// The lines of the file of sums, each SUM and NAME.
Result<std::vector<std::pair<std::string, std::string>>> read_sums(const fs::path& path) {
  errno = 0;
  std::ifstream file(path);
  std::vector<std::pair<std::string, std::string>> sums;
  for (std::string line; std::getline(file, line);) {
    const std::size_t blank = line.find("  ");
    if (blank == std::string::npos) return not_whole(path);
    sums.emplace_back(line.substr(0, blank), line.substr(blank + 2));
  }
  if (!file.eof()) return file_error(path, errno);
  if (sums.empty() || sums.front().second != kParts) return not_whole(path);
  return sums;
}

Result<std::string> sum_of(std::FILE* file, const fs::path& path) {
  Sha256 sum;
  std::string bytes(std::size_t{1} << 20, '\0');
  while (const std::size_t got = std::fread(bytes.data(), 1, bytes.size(), file))
    sum.add(std::as_bytes(std::span(bytes.data(), got)));
  if (std::ferror(file) != 0) return file_error(path, errno);
  return sum.hex();
}

/// Compares the sum of each mesh, and returns their sizes.
Result<MeshSizes> check_meshes(const fs::path& directory,
                               std::span<const std::pair<std::string, std::string>> sums) {
  MeshSizes sizes;
  for (const auto& [sum, name] : sums) {
    const fs::path path = directory / mesh_name(sum);
    if (name != mesh_name(sum)) return not_whole(directory / kSums);
    const File file(std::fopen(path.c_str(), "re"));
    if (!file) return file_error(path, errno);
    const auto found = sum_of(file.get(), path);
    if (!found) return found.error();
    if (*found != sum) return not_whole(path);
    std::error_code error;
    sizes[sum] = fs::file_size(path, error);
    if (error) return file_error(path, error.value());
  }
  return sizes;
}

}  // namespace

Result<BackupFileWriter> BackupFileWriter::create(const fs::path& directory,
                                                  const fs::path& since) {
  MeshSizes earlier;
  if (!since.empty()) {
    const auto backup = BackupFileReader::open(since);
    if (!backup) return backup.error();
    earlier = backup->meshes();
  }
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) return file_error(directory, error.value());
  const bool empty = fs::is_empty(directory, error);
  if (error) return file_error(directory, error.value());
  if (!empty) {
    return Error{Code::kFailedPrecondition,
                 fmt::format("{} is not empty: name a new directory", directory.string()),
                 "BACKUP_NOT_EMPTY"};
  }
  const fs::path path = directory / kIncomplete;
  File file(std::fopen(path.c_str(), "wxe"));
  if (!file) return file_error(path, errno);
  fs::create_directory(directory / kMeshFolder, error);
  if (error) return file_error(directory / kMeshFolder, error.value());
  return BackupFileWriter(directory, std::move(file),
                          BackupMeshWriter(directory, since, std::move(earlier)));
}

/// A mesh becomes a file, and a part with its digest alone.
Status BackupFileWriter::add(const v1::BackupPart& part) {
  if (!part.has_mesh()) return write_part(part);
  if (Status added = meshes_.add(part.mesh()); !added) return added;
  if (part.mesh().more()) return {};
  v1::BackupPart named;
  named.mutable_mesh()->set_digest(part.mesh().digest());
  return write_part(named);
}

Status BackupFileWriter::write_part(const v1::BackupPart& part) {
  const std::string bytes = part.SerializeAsString();
  const auto size = static_cast<std::uint32_t>(bytes.size());
  std::string length(sizeof size, '\0');
  for (std::size_t i = 0; i < length.size(); ++i) length[i] = static_cast<char>(size >> (8 * i));
  if (Status written = write(length); !written) return written;
  return write(bytes);
}

Status BackupFileWriter::write(const std::string& bytes) {
  sum_.add(std::as_bytes(std::span(bytes)));
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size()) return {};
  return file_error(directory_ / kIncomplete, errno);
}

std::string BackupFileWriter::sums_text() {
  std::string text = sums_line(sum_.hex(), kParts);
  for (const std::string& sum : meshes_.sums()) text += sums_line(sum, mesh_name(sum));
  return text;
}

Status BackupFileWriter::finish() {
  const fs::path written = directory_ / kIncomplete;
  if (!meshes_.is_whole()) return not_whole(written);
  if (std::fflush(file_.get()) != 0) return file_error(written, errno);
  if (Status synced = sync_all(file_.get(), written); !synced) return synced;
  if (Status sums = write_file(directory_ / kSums, sums_text()); !sums) return sums;
  std::error_code error;
  fs::rename(written, directory_ / kParts, error);
  if (error) return file_error(written, error.value());
  return sync(directory_);
}

Result<BackupFileReader> BackupFileReader::open(const fs::path& directory) {
  const fs::path path = directory / kParts;
  File file(std::fopen(path.c_str(), "re"));
  if (!file) return file_error(path, errno);
  const auto sums = read_sums(directory / kSums);
  if (!sums) return sums.error();
  const auto sum = sum_of(file.get(), path);
  if (!sum) return sum.error();
  if (*sum != sums->front().first) return not_whole(path);
  auto meshes = check_meshes(directory, std::span(*sums).subspan(1));
  if (!meshes) return meshes.error();
  std::rewind(file.get());
  return BackupFileReader(directory, path, std::move(file), *std::move(meshes));
}

Result<bool> BackupFileReader::next(v1::BackupPart& part) {
  if (!mesh_.is_reading()) {
    auto more = read_part(part);
    // A mesh has bytes: one without them is named, and has a file.
    if (!more || !*more || !part.has_mesh() || !part.mesh().data().empty()) return more;
    if (const Status begun = mesh_.begin(part.mesh().digest()); !begun) return begun.error();
  }
  part.Clear();
  if (const Status read = mesh_.next(*part.mutable_mesh()); !read) return read.error();
  return true;
}

Result<bool> BackupFileReader::read_part(v1::BackupPart& part) {
  std::array<unsigned char, 4> length{};
  const std::size_t got = std::fread(length.data(), 1, length.size(), file_.get());
  if (got == 0 && std::feof(file_.get()) != 0) return false;
  std::uint32_t size = 0;
  for (std::size_t i = 0; i < length.size(); ++i) size |= std::uint32_t{length[i]} << (8 * i);
  if (got != length.size() || size > kLargestPart) return not_whole(path_);
  bytes_.resize(size);
  if (std::fread(bytes_.data(), 1, size, file_.get()) != size ||
      !part.ParseFromArray(bytes_.data(), static_cast<int>(size)))
    return not_whole(path_);
  return true;
}

}  // namespace sightline::client
