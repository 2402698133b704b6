// SHA-256 of bytes that arrive in pieces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

struct evp_md_ctx_st;

namespace sightline::server::blobs {

using Sha256Sum = std::array<std::uint8_t, 32>;

class Sha256 {
 public:
  /// Throws std::bad_alloc where the library cannot give a context.
  Sha256();

  void update(std::span<const std::byte> bytes);
  /// The sum of all bytes so far; call it once, last.
  Sha256Sum finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

}  // namespace sightline::server::blobs
