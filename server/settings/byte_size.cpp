// Sizes in bytes, as people write them: 4G, 512MiB, 64k.
#include "server/settings/byte_size.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <optional>
#include <system_error>

#include "server/exec/rpc_status.h"
#include "server/settings/settings_file.h"

namespace sightline::server::settings {
namespace {

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

/// The bytes of a unit; nothing if there is no such unit.
std::optional<std::uint64_t> bytes_of_unit(std::string_view unit) {
  if (unit.empty() || unit == "B") return 1;
  constexpr std::string_view kSmall = "kmgt", kLarge = "KMGT";
  const bool is_small = kSmall.find(unit.front()) != kSmall.npos;
  const std::size_t power = (is_small ? kSmall : kLarge).find(unit.front());
  if (power == kLarge.npos) return {};
  const std::string_view rest = unit.substr(1);
  // A small letter before a B could mean bits or thousandths, except for the k of kB.
  if (is_small && !rest.empty() && unit != "kB") return {};
  if (!rest.empty() && rest != "iB" && rest != "B") return {};
  std::uint64_t bytes = 1;
  for (std::size_t i = 0; i <= power; ++i) bytes *= rest == "B" ? 1000 : 1024;
  return bytes;
}

}  // namespace

Result<std::uint64_t> parse_byte_size(std::string_view text, std::uint64_t least) {
  std::uint64_t count = 0;
  const char* const end = text.data() + text.size();
  const auto [parsed_to, error] = std::from_chars(text.data(), end, count);
  const auto unit = bytes_of_unit({parsed_to, static_cast<std::size_t>(end - parsed_to)});
  const bool is_number = error == std::errc{} && unit.has_value();
  if (is_number && count <= kMost / *unit && count * *unit >= least) return count * *unit;
  return exec::invalid_argument(
      fmt::format(
          "{} is not a size from {} to {} bytes: a whole number, alone or with K, M, G or T "
          "(KiB, MiB, GiB, TiB; times 1024) or kB, MB, GB or TB (times 1000)",
          exec::quote(text), least, kMost),
      kBadSettings);
}

}  // namespace sightline::server::settings
