// SHA-256 of bytes that come in pieces. Internal to the library.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

struct evp_md_ctx_st;

namespace sightline::client {

class Sha256 {
 public:
  /// Throws std::bad_alloc.
  Sha256();

  void add(std::span<const std::byte> bytes);
  /// 64 hex digits. Call it once, after all bytes.
  std::string hex();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

}  // namespace sightline::client
