// Whether a row is what was written.
#include "server/store/checksum.h"

#include <cstring>

#include "server/blobs/digest.h"

namespace sightline::server::store {

std::int64_t checksum_of(std::span<const std::byte> bytes) {
  blobs::Sha256 sum;
  sum.update(bytes);
  const blobs::Sha256Sum all = sum.finish();
  std::int64_t first = 0;
  std::memcpy(&first, all.data(), sizeof(first));
  return first;
}

}  // namespace sightline::server::store
