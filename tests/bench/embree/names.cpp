// The command line's names of Embree's builders.
#include <array>
#include <cstddef>

#include "tests/bench/embree/peer.h"

namespace sightline::bench {
namespace {

struct Named {
  std::string_view name;
  EmbreeSettings settings;
};

constexpr std::array<Named, 6> kNamed{{
    {"embree-low", {.quality = EmbreeQuality::kLow}},
    {"embree-medium", {.quality = EmbreeQuality::kMedium}},
    {"embree-high", {.quality = EmbreeQuality::kHigh}},
    {"embree-low-robust", {.quality = EmbreeQuality::kLow, .robust = true}},
    {"embree-medium-robust", {.quality = EmbreeQuality::kMedium, .robust = true}},
    {"embree-medium-robust-single",
     {.quality = EmbreeQuality::kMedium, .robust = true, .single = true}},
}};

constexpr auto kNames = [] {
  std::array<std::string_view, kNamed.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kNamed[i].name;
  return names;
}();

}  // namespace

std::span<const std::string_view> embree_names() { return kNames; }

std::optional<EmbreeSettings> parse_embree(std::string_view name) {
  for (const Named& named : kNamed) {
    if (named.name == name) return named.settings;
  }
  return std::nullopt;
}

}  // namespace sightline::bench
