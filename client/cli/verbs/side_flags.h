// The flags that say how the sides of points are found.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/cast_options.h"
#include "client/cli/files/hit_columns.h"

namespace CLI {
class App;
}

namespace sightline::client::cli::verbs {

struct SideArguments {
  std::string rule{};
  std::uint32_t rays = 0;  ///< 0: not given
};

/// Adds --side and --side-rays. `sides` receives their values, and must live until the program has
/// been parsed.
void add_side_flags(CLI::App& verb, SideArguments& sides);

/// Throws a CLI11 error, which is a usage error, if --side-rays is more than 1 with --side normal.
void check_side_rays(const SideArguments& sides);

/// As check_side_rays(), and throws where the columns do not go with the flags.
void check_sides(const SideArguments& sides, const std::vector<files::HitColumn>& columns);

/// Writes the values to the options of a query.
void set_sides(const SideArguments& sides, CastOptions& options);

}  // namespace sightline::client::cli::verbs
