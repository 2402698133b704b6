// The name of a blob: "sha256:<64 hex digits>/<size in bytes>".
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

#include "accel/result.h"
#include "server/blobs/sha256.h"

namespace sightline::server::blobs {

struct BlobDigest {
  Sha256Sum sum{};
  std::uint64_t size = 0;  ///< Bytes.

  auto operator<=>(const BlobDigest&) const = default;

  /// Takes only the canonical form (lower-case digits, no leading zeros), so that equal digests are
  /// equal text. Errors: kInvalidArgument.
  static Result<BlobDigest> parse(std::string_view text);
  std::string text() const;
};

}  // namespace sightline::server::blobs
