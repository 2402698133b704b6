// The errors of a store. Each names the file and what to do about it.
#include "server/store/errors.h"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

namespace sightline::server::store {

Error disk_full(const std::filesystem::path& file) {
  return {Code::kResourceExhausted,
          fmt::format("the disk of {} is full; free space on it, or remove scenes", file.string()),
          "DISK_FULL"};
}

Error read_only(const std::filesystem::path& file) {
  return {Code::kFailedPrecondition,
          fmt::format("{} cannot be written to; mount its file system for writing, or give the "
                      "directory and its files to the user of this process",
                      file.string()),
          "STORE_READ_ONLY"};
}

Error corrupt(const std::filesystem::path& file, std::string_view what) {
  return {Code::kDataLoss,
          fmt::format("{} is damaged: {}; run `sightlined doctor {}`, or restore a backup",
                      file.string(), what, file.parent_path().string()),
          "STORE_CORRUPT"};
}

bool is_of_engine(const Error& error) {
  return (error.code == Code::kUnavailable && error.reason != "STORE_BUSY") ||
         error.reason == "DISK_FULL" || error.reason == "STORE_READ_ONLY";
}

Error over_limit(std::string_view name, std::uint64_t use, std::uint64_t limit,
                 std::string reason) {
  return {Code::kResourceExhausted,
          fmt::format("{} would be {}, the limit is {}", name, use, limit), std::move(reason)};
}

Error file_error(std::string_view action, const std::filesystem::path& file, int number) {
  switch (number) {
    case ENOSPC:
    case EDQUOT:
      return disk_full(file);
    case EROFS:
    case EACCES:
    case EPERM:
      return read_only(file);
    default:
      return {Code::kUnavailable,
              fmt::format("cannot {} {}: {}; look at the disk and the kernel's log", action,
                          file.string(), std::generic_category().message(number)),
              "STORE_IO"};
  }
}

}  // namespace sightline::server::store
