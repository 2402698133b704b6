// Whether the disk has space for what is to be written.
#include "server/store/disk_budget.h"

#include <fmt/format.h>

#include "server/store/errors.h"

namespace sightline::server::store {

Status DiskBudget::admit(std::uint64_t bytes) const {
  const std::uint64_t use = used() + reserved_ + bytes;
  if (use > limits_.disk_bytes) {
    return over_limit(fmt::format("disk_bytes of {}", directory_.string()), use, limits_.disk_bytes,
                      "TOO_MANY_BYTES");
  }
  const auto free = files_.bytes_free(directory_);
  if (!free) return free.error();
  const std::uint64_t needed = reserved_ + bytes;
  if (*free >= needed && *free - needed >= limits_.min_free_disk) return {};
  Error error = disk_full(directory_);
  error.message += fmt::format(" ({} bytes are free, {} are needed and min_free_disk is {})", *free,
                               needed, limits_.min_free_disk);
  return error;
}

std::uint64_t DiskBudget::free() const {
  const auto bytes = files_.bytes_free(directory_);
  return bytes ? *bytes : 0;
}

}  // namespace sightline::server::store
