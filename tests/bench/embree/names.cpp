// The command line's names of Embree's builders.
#include <algorithm>
#include <array>
#include <utility>

#include "tests/bench/embree/peer.h"

namespace sightline::bench {
namespace {

constexpr std::array<std::string_view, 5> kNames{"embree-low", "embree-medium", "embree-high",
                                                 "embree-low-robust", "embree-medium-robust"};
constexpr std::array<EmbreeSettings, 5> kSettings{{{EmbreeQuality::kLow, false, false},
                                                   {EmbreeQuality::kMedium, false, false},
                                                   {EmbreeQuality::kHigh, false, false},
                                                   {EmbreeQuality::kLow, true, false},
                                                   {EmbreeQuality::kMedium, true, false}}};

}  // namespace

std::span<const std::string_view> embree_names() { return kNames; }

std::optional<EmbreeSettings> parse_embree(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return kSettings[static_cast<std::size_t>(found - kNames.begin())];
}

}  // namespace sightline::bench
