// Bits from the system, laid out as RFC 9562 says.
#include "client/calls/request_id.h"

#include <fmt/format.h>

#include <cstdint>
#include <random>

namespace sightline::client::calls {

std::string random_request_id() {
  std::random_device device;
  const auto word = [&device] { return std::uint64_t{device()} << 32U | device(); };
  const std::uint64_t high = (word() & ~std::uint64_t{0xf000}) | 0x4000U;
  const std::uint64_t low = (word() & ~(std::uint64_t{3} << 62U)) | std::uint64_t{1} << 63U;
  return fmt::format("{:016x}{:016x}", high, low);
}

}  // namespace sightline::client::calls
