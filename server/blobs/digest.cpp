// The name of a blob: the digest and the size of its bytes.
#include "server/blobs/digest.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <charconv>
#include <new>

#include "server/exec/rpc_status.h"

namespace sightline::server::blobs {
namespace {

constexpr std::string_view kPrefix = "sha256:";

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

bool parse_sum(std::string_view hex, Sha256Sum& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const int high = hex_digit(hex[2 * i]);
    const int low = hex_digit(hex[2 * i + 1]);
    if (high < 0 || low < 0) return false;
    sum[i] = static_cast<std::uint8_t>(high * 16 + low);
  }
  return true;
}

bool parse_size(std::string_view digits, std::uint64_t& size) {
  if (digits.empty() || (digits.front() == '0' && digits.size() > 1)) return false;
  const char* end = digits.data() + digits.size();
  const auto [parsed_to, error] = std::from_chars(digits.data(), end, size);
  return error == std::errc{} && parsed_to == end;
}

}  // namespace

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

Result<BlobDigest> BlobDigest::parse(std::string_view text) {
  constexpr std::size_t kHex = 2 * std::tuple_size_v<Sha256Sum>;
  BlobDigest digest;
  const bool good = text.size() > kPrefix.size() + kHex && text.starts_with(kPrefix) &&
                    text[kPrefix.size() + kHex] == '/' &&
                    parse_sum(text.substr(kPrefix.size(), kHex), digest.sum) &&
                    parse_size(text.substr(kPrefix.size() + kHex + 1), digest.size);
  if (good) return digest;
  return Error{Code::kInvalidArgument,
               fmt::format("{} is not a digest of the form sha256:<64 hex digits>/<size>",
                           exec::quote(text)),
               "BAD_DIGEST"};
}

std::string BlobDigest::text() const {
  std::string out(kPrefix);
  for (const std::uint8_t byte : sum) out += fmt::format("{:02x}", byte);
  return out + fmt::format("/{}", size);
}

}  // namespace sightline::server::blobs
