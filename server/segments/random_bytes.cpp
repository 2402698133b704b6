// Names and keys that cannot be guessed.
#include "server/segments/random_bytes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace sightline::server::segments {

void fill_at_random(std::span<std::uint8_t> bytes) {
  if (getentropy(bytes.data(), bytes.size()) != 0)
    throw std::system_error(errno, std::generic_category(), "getentropy");
}

std::string random_name() {
  std::array<std::uint8_t, 16> bits{};
  fill_at_random(bits);
  std::string name;
  for (const std::uint8_t byte : bits) name += fmt::format("{:02x}", byte);
  return name;
}

}  // namespace sightline::server::segments
