// What --builder names: one of our builders with its parameters, or Embree.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "accel/published/any_builder.h"
#include "accel/result.h"
#include "tests/bench/embree/peer.h"
#include "tests/bench/verbs/options.h"

namespace sightline::bench {

struct Contender {
  std::string name{};
  std::variant<accel::published::AnyBuilder, EmbreeSettings> what{};

  const accel::published::AnyBuilder* ours() const {
    return std::get_if<accel::published::AnyBuilder>(&what);
  }
  const EmbreeSettings* embree() const { return std::get_if<EmbreeSettings>(&what); }
};

/// Ours take the --set parameters, Embree has none. Where this program was built without Embree,
/// its names are left out with a word on stderr. Errors: kInvalidArgument: no such builder or
/// parameter; kFailedPrecondition: none is left.
Result<std::vector<Contender>> parse_contenders(const std::vector<std::string>& names,
                                                const CommonOptions& common);

/// One of our builders with the --set parameters, then its own: NAME?key=value&key=value. An empty
/// name: the default builder.
Result<accel::published::AnyBuilder> configured_builder(const std::string& text,
                                                        const CommonOptions& common);

struct BuildCosts {
  double traverse = 0, intersect = 0;
};
/// What the builder weighs costs by; nothing if it does not.
std::optional<BuildCosts> build_costs(const accel::published::AnyBuilder& builder);

/// A peer a contender, null for ours, each warmed by a build that is not counted.
Result<std::vector<std::unique_ptr<EmbreePeer>>> open_peers(
    const std::vector<Contender>& contenders, const SceneSource& scene, int threads);

/// Says so on stderr and returns true where Embree is asked for and not there.
bool embree_is_missing(std::string_view name);

}  // namespace sightline::bench
