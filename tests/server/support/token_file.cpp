// Files of tokens.
#include "tests/server/support/token_file.h"

#include <fmt/format.h>
#include <openssl/sha.h>

#include <array>

namespace sightline::tests {

std::string hash_of(std::string_view token) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), hash.data());
  std::string digits;
  for (const unsigned char byte : hash) digits += fmt::format("{:02x}", byte);
  return digits;
}

std::string token_row(std::string_view name, std::string_view token, std::string_view role,
                      std::string_view prefixes) {
  return fmt::format("[[token]]\nname = \"{}\"\nsha256 = \"{}\"\nrole = \"{}\"\nscenes = [{}]\n",
                     name, hash_of(token), role, prefixes);
}

}  // namespace sightline::tests
