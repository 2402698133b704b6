// Adds up the pieces between the holes.
#include "client/importer/sandbox/stored_bytes.h"

#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace sightline::client::importer::sandbox {
namespace {

constexpr std::uint64_t kBlock = 512;  // the unit of st_blocks, in bytes

/// The rest of a file of too many pieces, by what its file system has taken for it.
std::uint64_t by_blocks(int file, std::uint64_t size) {
  struct stat status {};
  if (::fstat(file, &status) != 0) return 0;
  return std::min(size, static_cast<std::uint64_t>(status.st_blocks) * kBlock);
}

}  // namespace

std::uint64_t stored_bytes(int file, std::uint64_t size) {
  std::uint64_t stored = 0;
  auto at = off_t{0};
  const auto end = static_cast<off_t>(size);
  for (int piece = 0; at < end; ++piece) {
    if (piece == kMostPieces) return by_blocks(file, size);
    const off_t begin = ::lseek(file, at, SEEK_DATA);
    if (begin < 0) return errno == ENXIO ? stored : size;  // ENXIO: the rest is a hole
    if (begin >= end) return stored;
    const off_t hole = ::lseek(file, begin, SEEK_HOLE);
    if (hole <= begin) return size;
    at = std::min(hole, end);
    stored += static_cast<std::uint64_t>(at - begin);
  }
  return stored;
}

}  // namespace sightline::client::importer::sandbox
