// openat2 resolves a name without ever leaving the folder.
#include "client/importer/sandbox/folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "client/importer/sandbox/stored_bytes.h"

namespace sightline::client::importer::sandbox {
namespace {

constexpr std::size_t kMostRefusals = 4;
constexpr int kRead = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
constexpr int kLook = O_PATH | O_CLOEXEC;  // opens no device and does not wait for a pipe

// What keeps a file from being read, or null.
const char* oddity(const struct stat& status) {
  if (S_ISREG(status.st_mode)) return nullptr;
  if (S_ISDIR(status.st_mode)) return "is a directory";
  if (S_ISFIFO(status.st_mode)) return "is a pipe";
  if (S_ISSOCK(status.st_mode)) return "is a socket";
  return "is a device";
}

const char* oddity(const FileHandle& file) {
  struct stat status {};
  return ::fstat(file.get(), &status) == 0 ? oddity(status) : "cannot be read";
}

FileHandle open_below(const FileHandle& folder, const std::string& name, int flags) {
  struct open_how how {};
  how.flags = static_cast<std::uint64_t>(flags);
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
  return FileHandle(
      static_cast<int>(::syscall(SYS_openat2, folder.get(), name.c_str(), &how, sizeof(how))));
}

}  // namespace

Error file_error(const std::filesystem::path& file, const std::string& why) {
  return {Code::kInvalidArgument, fmt::format("{}: {}", file.string(), why), {}};
}

Result<FileHandle> open_regular(const std::filesystem::path& file) {
  const FileHandle seen(::open(file.c_str(), kLook));
  if (!seen) return file_error(file, std::generic_category().message(errno));
  if (const char* const why = oddity(seen)) return file_error(file, why);
  FileHandle opened(::open(file.c_str(), kRead));
  if (!opened) return file_error(file, std::generic_category().message(errno));
  if (const char* const why = oddity(opened)) return file_error(file, why);
  return opened;
}

Result<SceneFolder> SceneFolder::open(const std::filesystem::path& file, const Allowance& memory) {
  auto scene = open_regular(file);
  if (!scene) return scene.error();
  const std::filesystem::path parent = file.has_parent_path() ? file.parent_path() : ".";
  FileHandle folder(::open(parent.c_str(), kLook | O_DIRECTORY));
  if (!folder) return file_error(parent, std::generic_category().message(errno));
  return SceneFolder(file.filename().string(), std::move(folder), *std::move(scene), memory);
}

std::optional<OpenedFile> SceneFolder::open_file(const std::string& name) {
  if (name == name_ || name == "./" + name_)
    return measured(name, FileHandle(::fcntl(scene_.get(), F_DUPFD_CLOEXEC, 0)));
  const FileHandle seen = open_below(folder_, name, kLook);
  if (!seen) {
    if (errno == EXDEV || errno == ELOOP) refuse(name, "is outside the folder of the scene file");
    if (errno == ENOSYS || errno == EPERM) refuse(name, "cannot be opened safely on this system");
    return {};
  }
  if (const char* const why = oddity(seen)) {
    refuse(name, why);
    return {};
  }
  FileHandle opened = open_below(folder_, name, kRead);
  if (!opened || oddity(opened) != nullptr) return {};
  return measured(name, std::move(opened));
}

std::optional<OpenedFile> SceneFolder::measured(const std::string& name, FileHandle file) {
  struct stat status {};
  if (!file || ::fstat(file.get(), &status) != 0) return {};
  const auto size = static_cast<std::uint64_t>(status.st_size);
  const std::pair<std::uint64_t, std::uint64_t> identity{status.st_dev, status.st_ino};
  if (const auto seen = seen_.find(identity); seen != seen_.end())
    return OpenedFile{std::move(file), size, seen->second};
  const std::uint64_t stored = stored_bytes(file.get(), size);
  // The pages of a hole take memory when they are read.
  const std::uint64_t most = memory_.of(bytes_ + stored);
  if (size > stored && (sizes_ > most || size > most - sizes_)) {
    refuse(name, fmt::format("is a hole: of its {} bytes {} are stored", size, stored));
    return {};
  }
  bytes_ += stored;
  sizes_ += size;
  const std::uint64_t number = seen_.size();
  seen_.emplace(identity, number);
  return OpenedFile{std::move(file), size, number};
}

void SceneFolder::refuse(const std::string& name, std::string_view why) {
  const std::string plain = std::filesystem::path(name).lexically_normal().string();
  std::string refusal = fmt::format("it names '{}', which {}", plain, why);
  const bool is_new = std::find(refusals_.begin(), refusals_.end(), refusal) == refusals_.end();
  if (is_new && refusals_.size() < kMostRefusals) refusals_.push_back(std::move(refusal));
}

}  // namespace sightline::client::importer::sandbox
