// SHA-256 of bytes that arrive in pieces.
#include "server/blobs/sha256.h"

#include <openssl/evp.h>

#include <new>

namespace sightline::server::blobs {

void Sha256::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) {
    throw std::bad_alloc();
  }
}

void Sha256::update(std::span<const std::byte> bytes) {
  EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size());
}

Sha256Sum Sha256::finish() {
  Sha256Sum sum{};
  EVP_DigestFinal_ex(context_.get(), sum.data(), nullptr);
  return sum;
}

}  // namespace sightline::server::blobs
