// The file system of this machine, by calls of POSIX and Linux.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "server/store/errors.h"
#include "server/store/file_system.h"

namespace sightline::server::store {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kFileMode = 0640;
constexpr mode_t kDirectoryMode = 0750;

Error failed(std::string_view action, const fs::path& path) {
  return file_error(action, path, errno);
}

Error missing(const fs::path& file) {
  return {Code::kNotFound, "there is no file " + file.string(), "FILE_MISSING"};
}

/// Calls again what a signal has interrupted.
template <class Call>
auto repeat(const Call& call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

/// Whether the open file is the one of this name.
bool is_named(const net::Descriptor& opened, const fs::path& file) {
  struct stat one {};
  struct stat other {};
  return fstat(opened.number(), &one) == 0 && ::stat(file.c_str(), &other) == 0 &&
         one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

class LocalMapping final : public MappedFile {
 public:
  LocalMapping(void* begin, std::size_t size) : begin_(begin), size_(size) {}
  ~LocalMapping() override {
    if (size_ > 0) munmap(begin_, size_);
  }
  LocalMapping(const LocalMapping&) = delete;
  LocalMapping& operator=(const LocalMapping&) = delete;

  std::span<const std::byte> bytes() const override {
    return {static_cast<const std::byte*>(begin_), size_};
  }

 private:
  void* begin_;
  std::size_t size_;
};

/// The f_type of statfs, from the manual page and from sources of the kernel.
constexpr std::array<std::pair<std::uint32_t, const char*>, 12> kNetworks{{
    {0x00006969, "NFS"},
    {0x0000517B, "SMB"},
    {0xFE534D42, "SMB2"},
    {0xFF534D42, "CIFS"},
    {0x00C36400, "Ceph"},
    {0x5346414F, "AFS"},
    {0x73757245, "Coda"},
    {0x01021997, "9P"},
    {0x0BD00BD0, "Lustre"},
    {0x01161970, "GFS2"},
    {0x7461636F, "OCFS2"},
    {0x65735546, "FUSE"},
}};

Status write_all(int number, std::span<const std::byte> bytes, const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = repeat([&] { return ::write(number, bytes.data(), bytes.size()); });
    if (written < 0) return failed("write", path);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

Status sync_number(int number, const fs::path& path) {
  if (repeat([&] { return ::fsync(number); }) != 0) return failed("sync", path);
  return {};
}

class LocalFiles final : public FileSystem {
 public:
  Status make_directory(const Path& directory) override {
    if (::mkdir(directory.c_str(), kDirectoryMode) != 0 && errno != EEXIST)
      return failed("make the directory", directory);
    return {};
  }

  Result<net::Descriptor> create(const Path& file) override {
    net::Descriptor opened(repeat(
        [&] { return ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kFileMode); }));
    if (!opened) return failed("create", file);
    return opened;
  }

  Status write(const net::Descriptor& file, std::span<const std::byte> bytes,
               const Path& path) override {
    return write_all(file.number(), bytes, path);
  }

  Result<net::Descriptor> open(const Path& file) override {
    net::Descriptor opened(
        repeat([&] { return ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, kFileMode); }));
    if (!opened) return failed("open", file);
    return opened;
  }

  Status write_at(const net::Descriptor& file, std::span<const std::byte> bytes,
                  std::uint64_t offset, const Path& path) override {
    while (!bytes.empty()) {
      const ssize_t written = repeat([&] {
        return ::pwrite(file.number(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
      });
      if (written < 0) return failed("write", path);
      bytes = bytes.subspan(static_cast<std::size_t>(written));
      offset += static_cast<std::uint64_t>(written);
    }
    return {};
  }

  Status sync(const net::Descriptor& file, const Path& path) override {
    return sync_number(file.number(), path);
  }

  Status sync_directory(const Path& directory) override {
    const net::Descriptor opened(
        repeat([&] { return ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); }));
    if (!opened) return failed("open", directory);
    return sync_number(opened.number(), directory);
  }

  Status rename(const Path& from, const Path& to) override {
    if (::rename(from.c_str(), to.c_str()) != 0) return failed("rename a file to", to);
    return {};
  }

  Status remove(const Path& file) override {
    if (::unlink(file.c_str()) != 0 && errno != ENOENT) return failed("remove", file);
    return {};
  }

  Result<std::unique_ptr<MappedFile>> map(const Path& file) override {
    const net::Descriptor opened(
        repeat([&] { return ::open(file.c_str(), O_RDONLY | O_CLOEXEC); }));
    if (!opened && errno == ENOENT) return missing(file);
    struct stat state {};
    if (!opened || ::fstat(opened.number(), &state) != 0) return failed("open", file);
    const auto size = static_cast<std::size_t>(state.st_size);
    void* begin = nullptr;
    if (size > 0) {
      begin = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, opened.number(), 0);
      if (begin == MAP_FAILED) return failed("map", file);
    }
    return std::unique_ptr<MappedFile>(std::make_unique<LocalMapping>(begin, size));
  }

  Result<std::vector<FileEntry>> list(const Path& directory) override {
    std::vector<FileEntry> files;
    std::error_code error;
    fs::directory_iterator entries(directory, error);
    if (error == std::errc::no_such_file_or_directory) return files;
    for (const fs::directory_iterator end; !error && entries != end; entries.increment(error)) {
      struct stat state {};
      // A file may be removed meanwhile.
      if (::lstat(entries->path().c_str(), &state) != 0 || !S_ISREG(state.st_mode)) continue;
      files.push_back({entries->path(), static_cast<std::uint64_t>(state.st_size),
                       std::chrono::system_clock::from_time_t(state.st_mtime)});
    }
    if (error) return file_error("list", directory, error.value());
    std::sort(files.begin(), files.end(),
              [](const FileEntry& a, const FileEntry& b) { return a.path < b.path; });
    return files;
  }

  bool exists(const Path& file) override { return ::access(file.c_str(), F_OK) == 0; }

  Result<net::Descriptor> lock(const Path& file) override {
    for (;;) {
      net::Descriptor opened(
          repeat([&] { return ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kFileMode); }));
      if (!opened) return failed("open", file);
      if (repeat([&] { return ::flock(opened.number(), LOCK_EX | LOCK_NB); }) != 0) {
        if (errno != EWOULDBLOCK) return failed("lock", file);
        return Error{Code::kAlreadyExists, file.string() + " is locked", "LOCKED"};
      }
      if (is_named(opened, file)) return opened;  // else its last owner has removed it meanwhile
    }
  }

  Result<std::uint64_t> bytes_free(const Path& directory) override {
    struct statvfs state {};
    if (repeat([&] { return ::statvfs(directory.c_str(), &state); }) != 0)
      return failed("measure the file system of", directory);
    return std::uint64_t{state.f_bavail} * state.f_frsize;
  }

  Result<std::string> network(const Path& directory) override {
    struct statfs state {};
    if (repeat([&] { return ::statfs(directory.c_str(), &state); }) != 0)
      return failed("measure the file system of", directory);
    const auto type = static_cast<std::uint32_t>(state.f_type);
    const auto* const found = std::find_if(kNetworks.begin(), kNetworks.end(),
                                           [&](const auto& entry) { return entry.first == type; });
    return found == kNetworks.end() ? std::string() : std::string(found->second);
  }
};

}  // namespace

FileSystem& local_files() {
  static LocalFiles files;
  return files;
}

}  // namespace sightline::server::store
