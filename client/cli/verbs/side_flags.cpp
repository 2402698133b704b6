// The limits are those of the server, so that a value beyond them is a usage error.
#include "client/cli/verbs/side_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>

#include "client/cli/flags.h"

namespace sightline::client::cli::verbs {
namespace {

using files::HitColumn;

const std::map<std::string, SideRule> kSideRules{
    {"parity", SideRule::kParity}, {"winding", SideRule::kWinding}, {"normal", SideRule::kNormal}};

bool has(const std::vector<HitColumn>& columns, HitColumn column) {
  return std::find(columns.begin(), columns.end(), column) != columns.end();
}

CLI::Validator odd_number() {
  return {[](std::string& text) -> std::string {
            const auto number = parse_number(text);
            const bool is_odd =
                number && *number >= 1 && *number <= kMaxSideRays && std::fmod(*number, 2) == 1;
            return is_odd
                       ? ""
                       : fmt::format("'{}' is not an odd number from 1 to {}", text, kMaxSideRays);
          },
          ""};
}

}  // namespace

void add_side_flags(CLI::App& verb, SideArguments& sides) {
  verb.add_option("--side", sides.rule,
                  "What decides whether a point is inside: an odd number of faces along a ray, the "
                  "windings of the faces along it, or the normals of the nearest ones (default "
                  "parity)")
      ->check(CLI::IsMember(kSideRules).description(""))
      ->type_name("parity|winding|normal");
  verb.add_option("--side-rays", sides.rays,
                  "Rays from each point whose majority decides, an odd number up to 63: more of "
                  "them find holes (default 1)")
      ->check(odd_number())
      ->type_name("N");
}

void check_side_rays(const SideArguments& sides) {
  if (sides.rule == "normal" && sides.rays > 1) {
    throw CLI::ValidationError(
        "--side-rays", fmt::format("{} with --side normal, which casts no rays", sides.rays));
  }
}

void check_sides(const SideArguments& sides, const std::vector<HitColumn>& columns) {
  const bool is_asked = has(columns, HitColumn::kSigned) || has(columns, HitColumn::kInside) ||
                        has(columns, HitColumn::kVotes);
  if (!is_asked && (!sides.rule.empty() || sides.rays > 0)) {
    throw CLI::ValidationError(sides.rule.empty() ? "--side-rays" : "--side",
                               "it is for signed, inside and votes: name one of them in --fields");
  }
  check_side_rays(sides);
  if (sides.rule == "normal" && has(columns, HitColumn::kVotes))
    throw CLI::ValidationError("--fields", "votes are of rays, and --side normal casts none");
}

void set_sides(const SideArguments& sides, CastOptions& options) {
  if (!sides.rule.empty()) options.side_rule = kSideRules.at(sides.rule);
  options.side_rays = sides.rays;
}

}  // namespace sightline::client::cli::verbs
