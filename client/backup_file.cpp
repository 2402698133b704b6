// The file of a backup: parts, each after its length in 4 bytes, least significant first.
#include "client/backup_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <system_error>
#include <utility>

namespace sightline::client {
namespace {

namespace fs = std::filesystem;

constexpr const char* kParts = "scenes.parts";
constexpr const char* kIncomplete = "incomplete";
/// The file of sums, in the form of sha256sum.
constexpr const char* kSums = "SHA256SUMS";
/// A part is a message of the API, which is smaller.
constexpr std::uint32_t kLargestPart = std::uint32_t{64} << 20;

Error failed(const fs::path& path, int error) {
  return {Code::kInvalidArgument,
          fmt::format("{}: {}", path.string(), std::generic_category().message(error)),
          {}};
}

Error not_whole(const fs::path& path) {
  return {Code::kDataLoss,
          fmt::format("{} is not what was written: restore another backup", path.string()),
          "BACKUP_CORRUPT"};
}

std::string sums_line(const std::string& sum) { return fmt::format("{}  {}\n", sum, kParts); }

Status sync(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return failed(path, errno);
  const int error = fsync(file) == 0 ? 0 : errno;
  close(file);
  return error == 0 ? Status() : Status(failed(path, error));
}

Status write_file(const fs::path& path, const std::string& text) {
  const File file(std::fopen(path.c_str(), "wxe"));
  if (!file) return failed(path, errno);
  if (std::fwrite(text.data(), 1, text.size(), file.get()) != text.size() ||
      std::fflush(file.get()) != 0)
    return failed(path, errno);
  return sync(path);
}

/// The first line of the file; empty if it is empty.
Result<std::string> read_line(const fs::path& path) {
  const File file(std::fopen(path.c_str(), "re"));
  if (!file) return failed(path, errno);
  std::array<char, 256> line{};
  if (std::fgets(line.data(), static_cast<int>(line.size()), file.get()) == nullptr)
    return std::string();
  return std::string(line.data());
}

Result<std::string> sum_of(std::FILE* file, const fs::path& path) {
  Sha256 sum;
  std::string bytes(std::size_t{1} << 20, '\0');
  while (const std::size_t got = std::fread(bytes.data(), 1, bytes.size(), file))
    sum.add(std::as_bytes(std::span(bytes.data(), got)));
  if (std::ferror(file) != 0) return failed(path, errno);
  return sum.hex();
}

}  // namespace

Result<BackupFileWriter> BackupFileWriter::create(const fs::path& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) return failed(directory, error.value());
  const bool empty = fs::is_empty(directory, error);
  if (error) return failed(directory, error.value());
  if (!empty) {
    return Error{Code::kFailedPrecondition,
                 fmt::format("{} is not empty: name a new directory", directory.string()),
                 "BACKUP_NOT_EMPTY"};
  }
  const fs::path path = directory / kIncomplete;
  File file(std::fopen(path.c_str(), "wxe"));
  if (!file) return failed(path, errno);
  return BackupFileWriter(directory, std::move(file));
}

Status BackupFileWriter::add(const v1::BackupPart& part) {
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
  return failed(directory_ / kIncomplete, errno);
}

Status BackupFileWriter::finish() {
  const fs::path written = directory_ / kIncomplete;
  if (std::fflush(file_.get()) != 0) return failed(written, errno);
  if (Status synced = sync(written); !synced) return synced;
  if (Status sums = write_file(directory_ / kSums, sums_line(sum_.hex())); !sums) return sums;
  std::error_code error;
  fs::rename(written, directory_ / kParts, error);
  if (error) return failed(written, error.value());
  return sync(directory_);
}

Result<BackupFileReader> BackupFileReader::open(const fs::path& directory) {
  const fs::path path = directory / kParts;
  File file(std::fopen(path.c_str(), "re"));
  if (!file) return failed(path, errno);
  const auto expected = read_line(directory / kSums);
  if (!expected) return expected.error();
  const auto sum = sum_of(file.get(), path);
  if (!sum) return sum.error();
  if (sums_line(*sum) != *expected) return not_whole(path);
  std::rewind(file.get());
  return BackupFileReader(path, std::move(file));
}

Result<bool> BackupFileReader::next(v1::BackupPart& part) {
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
