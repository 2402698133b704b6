// The name of a blob: the digest and the size of its bytes.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "proto/result.h"

struct evp_md_ctx_st;

namespace sightline::server::blobs {

using Sha256Sum = std::array<std::uint8_t, 32>;

/// SHA-256 of bytes that arrive in pieces.
class Sha256 {
 public:
  /// Throws std::bad_alloc where the library cannot give a context.
  Sha256();

  void update(std::span<const std::byte> bytes);
  /// The sum of all bytes. Call it once, after the last update().
  Sha256Sum finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// The name of a blob, "sha256:<64 hex digits>/<size in bytes>".
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
