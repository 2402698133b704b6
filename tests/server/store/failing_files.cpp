// A file system, for blobs and for SQLite, whose calls fail when they are told to.
#include "tests/server/store/failing_files.h"

#include <sqlite3.h>

#include "server/store/errors.h"
#include "tests/server/store/failing_vfs.h"

namespace sightline::tests {

using server::net::Descriptor;
using server::store::file_error;

FailingFiles::FailingFiles()
    : vfs_name_("failing-" + std::to_string(reinterpret_cast<std::uintptr_t>(this))),
      vfs_(register_failing_vfs(*this, vfs_name_)) {}

FailingFiles::~FailingFiles() { unregister(*vfs_); }

void FailingFiles::fail(int call, int number, bool lasting) {
  number_ = number;
  lasting_ = lasting;
  failed_ = nullptr;
  calls_ = 0;
  call_ = call;
}

std::string FailingFiles::failed() const {
  const char* name = failed_;
  return name == nullptr ? std::string() : std::string(name);
}

int FailingFiles::next(const char* name) {
  const int now = ++calls_;
  const int failing = call_;
  if (failing == 0 || !(now == failing || (lasting_ && now > failing))) return 0;
  const char* none = nullptr;
  failed_.compare_exchange_strong(none, name);
  return number_;
}

Status FailingFiles::make_directory(const Path& directory) {
  if (const int number = next("mkdir")) return file_error("make", directory, number);
  return files_.make_directory(directory);
}

Result<Descriptor> FailingFiles::create(const Path& file) {
  if (const int number = next("open")) return file_error("create", file, number);
  return files_.create(file);
}

Status FailingFiles::write(const Descriptor& file, std::span<const std::byte> bytes,
                           const Path& path) {
  if (const int number = next("write")) {
    // As a full disk does: some of it is written.
    (void)files_.write(file, bytes.first(bytes.size() / 2), path);
    return file_error("write", path, number);
  }
  return files_.write(file, bytes, path);
}

Result<Descriptor> FailingFiles::open(const Path& file) {
  if (const int number = next("open")) return file_error("open", file, number);
  return files_.open(file);
}

Status FailingFiles::write_at(const Descriptor& file, std::span<const std::byte> bytes,
                              std::uint64_t offset, const Path& path) {
  if (const int number = next("write in place")) {
    (void)files_.write_at(file, bytes.first(bytes.size() / 2), offset, path);
    return file_error("write", path, number);
  }
  return files_.write_at(file, bytes, offset, path);
}

Status FailingFiles::sync(const Descriptor& file, const Path& path) {
  if (const int number = next("fsync")) return file_error("sync", path, number);
  return files_.sync(file, path);
}

Status FailingFiles::sync_directory(const Path& directory) {
  if (const int number = next("fsync of a directory")) return file_error("sync", directory, number);
  return files_.sync_directory(directory);
}

Status FailingFiles::rename(const Path& from, const Path& to) {
  if (const int number = next("rename")) return file_error("rename", to, number);
  return files_.rename(from, to);
}

Status FailingFiles::remove(const Path& file) {
  if (const int number = next("unlink")) return file_error("remove", file, number);
  return files_.remove(file);
}

Result<std::unique_ptr<server::store::MappedFile>> FailingFiles::map(const Path& file) {
  if (const int number = next("mmap")) return file_error("map", file, number);
  return files_.map(file);
}

Result<std::vector<server::store::FileEntry>> FailingFiles::list(const Path& directory) {
  if (const int number = next("readdir")) return file_error("list", directory, number);
  return files_.list(directory);
}

Result<Descriptor> FailingFiles::lock(const Path& file) {
  if (const int number = next("flock")) return file_error("lock", file, number);
  return files_.lock(file);
}

Result<std::uint64_t> FailingFiles::bytes_free(const Path& directory) {
  if (const int number = next("statvfs")) return file_error("measure", directory, number);
  return files_.bytes_free(directory);
}

}  // namespace sightline::tests
