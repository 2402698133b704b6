// Options that several verbs have.
#include "tests/bench/command_line/shared_options.h"

#include <string_view>

#include "accel/published/any_builder.h"
#include "tests/bench/embree/peer.h"

namespace sightline::bench {

void add_rays(CLI::App& verb, RayOptions& rays) {
  verb.add_option("--rays", rays.kind, kRayKinds)->required();
  verb.add_option("--count", rays.count, "How many rays")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}))
      ->required();
}

void add_builders(CLI::App& verb, std::vector<std::string>& builders) {
  std::string names;
  const auto add = [&](std::string_view name) {
    if (!names.empty()) names += '|';
    names += name;
  };
  for (const std::string_view name : accel::published::builder_names()) add(name);
  if (embree_found()) {
    for (const std::string_view name : embree_names()) add(name);
  }
  verb.add_option("--builder", builders,
                  names + "; several by commas: a row each; own parameters: NAME?key=value&...")
      ->delimiter(',')
      ->required();
}

}  // namespace sightline::bench
