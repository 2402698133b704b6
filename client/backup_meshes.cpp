// The meshes of a backup: a file each, named for its sum, so that the next backup can share it.
#include "client/backup_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <functional>
#include <span>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

namespace sightline::client {
namespace {

namespace files = std::filesystem;

/// As many as the server takes in a request (sightline/v1/backup.proto).
constexpr std::size_t kMostKnown = 8192;
constexpr std::size_t kPieceBytes = std::size_t{512} << 10;
constexpr std::string_view kSumKind = "sha256:";
constexpr std::size_t kSumDigits = 64;

Error broken_mesh(const std::string& digest, const char* what) {
  return {Code::kDataLoss, fmt::format("mesh {}: {}", digest, what), "BACKUP_CORRUPT"};
}

std::string digest_text(const std::string& sum, std::uint64_t size) {
  return fmt::format("{}{}/{}", kSumKind, sum, size);
}

}  // namespace

Error not_whole(const files::path& path) {
  return {Code::kDataLoss,
          fmt::format("{} is not what was written: restore another backup", path.string()),
          "BACKUP_CORRUPT"};
}

Error file_error(const files::path& path, int error) {
  return {Code::kInvalidArgument,
          fmt::format("{}: {}", path.string(), std::generic_category().message(error)),
          {}};
}

Result<std::pair<std::string, std::uint64_t>> parse_mesh_digest(const std::string& text) {
  const std::size_t size_at = kSumKind.size() + kSumDigits + 1;
  std::uint64_t size = 0;
  const char* const end = text.data() + text.size();
  if (text.size() > size_at && text.starts_with(kSumKind) && text[size_at - 1] == '/') {
    const std::string sum = text.substr(kSumKind.size(), kSumDigits);
    const auto [stopped, error] = std::from_chars(text.data() + size_at, end, size);
    // The sum becomes the name of a file.
    if (error == std::errc() && stopped == end &&
        sum.find_first_not_of("0123456789abcdef") == sum.npos)
      return std::pair(sum, size);
  }
  return broken_mesh("of a digest of another form", "it is not sha256:HEX/BYTES");
}

BackupMeshWriter::BackupMeshWriter(files::path directory, files::path since, MeshSizes earlier)
    : directory_(std::move(directory)), since_(std::move(since)), earlier_(std::move(earlier)) {}

std::vector<std::string> BackupMeshWriter::known() const {
  std::vector<std::pair<std::uint64_t, std::string>> by_size;
  for (const auto& [sum, size] : earlier_) by_size.emplace_back(size, sum);
  std::ranges::sort(by_size, std::greater());
  if (by_size.size() > kMostKnown) by_size.resize(kMostKnown);
  std::vector<std::string> digests;
  digests.reserve(by_size.size());
  for (const auto& [size, sum] : by_size) digests.push_back(digest_text(sum, size));
  return digests;
}

Status BackupMeshWriter::add(const v1::BackupMesh& piece) {
  if (is_whole()) {
    auto digest = parse_mesh_digest(piece.digest());
    if (!digest) return digest.error();
    digest_ = piece.digest();
    std::tie(sum_, size_) = *std::move(digest);
    taken_ = 0;
    if (Status begun = begin(); !begun) return begun;
  } else if (piece.digest() != digest_) {
    return broken_mesh(digest_, "it has no end");
  }
  taken_ += piece.data().size();
  if (file_ != nullptr) {
    hash_.add(std::as_bytes(std::span(piece.data())));
    if (std::fwrite(piece.data().data(), 1, piece.data().size(), file_.get()) !=
        piece.data().size())
      return file_error(path(), errno);
  }
  return piece.more() ? Status() : end();
}

Status BackupMeshWriter::begin() {
  const auto known = earlier_.find(sum_);
  linking_ = known != earlier_.end() && known->second == size_;
  if (linking_ || sums_.contains(sum_)) {
    linking_ = true;
    return {};
  }
  file_ = File(std::fopen(path().c_str(), "wxe"));
  if (file_ == nullptr) return file_error(path(), errno);
  hash_ = Sha256();
  return {};
}

Status BackupMeshWriter::end() {
  if (std::exchange(linking_, false)) {
    return sums_.insert(sum_).second ? link() : Status();
  }
  const bool is_written = std::fflush(file_.get()) == 0;
  const int error = errno;
  file_ = nullptr;
  if (!is_written) return file_error(path(), error);
  if (taken_ != size_ || hash_.hex() != sum_)
    return broken_mesh(digest_, "the server sent other bytes");
  sums_.insert(sum_);
  return {};
}

/// A copy where the file system has no links, or the earlier backup is on another one.
Status BackupMeshWriter::link() {
  const files::path earlier = since_ / kMeshFolder / sum_;
  std::error_code error;
  files::create_hard_link(earlier, path(), error);
  if (error) files::copy_file(earlier, path(), error);
  return error ? Status(file_error(path(), error.value())) : Status();
}

Status BackupMeshReader::begin(const std::string& digest) {
  auto parsed = parse_mesh_digest(digest);
  if (!parsed) return parsed.error();
  digest_ = digest;
  path_ = directory_ / kMeshFolder / parsed->first;
  rest_ = parsed->second;
  file_ = File(std::fopen(path_.c_str(), "re"));
  std::error_code error;
  if (file_ == nullptr || files::file_size(path_, error) != rest_ || rest_ == 0)
    return not_whole(path_);
  return {};
}

Status BackupMeshReader::next(v1::BackupMesh& piece) {
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(kPieceBytes, rest_));
  piece.set_digest(digest_);
  piece.mutable_data()->resize(size);
  if (std::fread(piece.mutable_data()->data(), 1, size, file_.get()) != size)
    return not_whole(path_);
  rest_ -= size;
  piece.set_more(rest_ > 0);
  if (rest_ == 0) file_ = nullptr;
  return {};
}

}  // namespace sightline::client
