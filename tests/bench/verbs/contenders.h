// The builders that --builder names: ours with their parameters, and Embree's.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "accel/published/any_builder.h"
#include "proto/result.h"
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

/// Our builders take the --set parameters; Embree's have none. If this program was built without
/// Embree, its names are left out with a message on stderr. Errors: kInvalidArgument: no such
/// builder or parameter; kFailedPrecondition: none is left.
Result<std::vector<Contender>> parse_contenders(const std::vector<std::string>& names,
                                                const CommonOptions& common);

/// One of our builders with the --set parameters, then its own: NAME?key=value&key=value. An empty
/// name is the default builder.
Result<accel::published::AnyBuilder> configured_builder(const std::string& text,
                                                        const CommonOptions& common);

struct BuildCosts {
  double traverse = 0, intersect = 0;
};
/// The builder's cost parameters; nothing if it has none.
std::optional<BuildCosts> build_costs(const accel::published::AnyBuilder& builder);

/// One peer for each contender, null for our builders; each is warmed by a build that is not timed.
Result<std::vector<std::unique_ptr<EmbreePeer>>> open_peers(
    const std::vector<Contender>& contenders, const SceneSource& scene, int threads);

/// Returns true and writes a message to stderr if Embree is requested and not available.
bool embree_is_missing(std::string_view name);

}  // namespace sightline::bench
