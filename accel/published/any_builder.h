// Builders chosen by name at run time: ours and the papers'.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "accel/mesh/tree_builder.h"
#include "accel/published/bvh/bvh_builder.h"
#include "accel/published/kd/exact_builder.h"
#include "accel/published/kd/hunt_scan.h"
#include "accel/published/kd/median_builders.h"
#include "accel/published/kd/min_max_builder.h"
#include "accel/published/kd/plain_rule.h"
#include "accel/split/scan_split.h"
#include "proto/result.h"

namespace sightline::accel::published {

/// Our rule, with the choice of the tree that it makes.
struct ScanBuilder : split::ScanSplit {
  ScanBuilder() = default;
  ScanBuilder(const split::ScanSplit& rule)  // NOLINT(google-explicit-constructor): it is the same
      : split::ScanSplit(rule) {}

  /// Whether it builds the product's tree, which ends in leaf blocks; else a plain kd-tree, down to
  /// leaves.
  bool blocks = true;

  bool operator==(const ScanBuilder&) const = default;
};

/// The value of a kd-tree builder: ours, or a paper's.
using KdBuilder = std::variant<ScanBuilder, kd::HuntScan, kd::SpatialMedianBuilder,
                               kd::ObjectMedianBuilder, kd::ExactBuilder, kd::MinMaxBuilder>;

/// How the builder grows plain kd-trees.
kd::PlainRule plain_rule(const KdBuilder& builder);

/// Any builder that has a name.
struct AnyBuilder : std::variant<KdBuilder, bvh::BvhBuilder> {
  using std::variant<KdBuilder, bvh::BvhBuilder>::variant;

  /// The builder in the form that meshes take.
  operator mesh::TreeBuilder() const;  // NOLINT(google-explicit-constructor): it is the same thing
};

/// The builder of the product: scan-fast.
AnyBuilder default_builder();

/// All names of builders, in the order of docs/builders.md: kd-trees first.
std::vector<std::string_view> builder_names();

/// The builder of that name with its default parameters. Errors: kInvalidArgument, listing the
/// names.
Result<AnyBuilder> make_builder(std::string_view name);

/// Sets one parameter by name, e.g. ("samples", "8") or ("clip", "off"). Errors: kInvalidArgument:
/// no such parameter (listing them), not a number (a whole number, on or off), or out of range
/// (naming the range); the builder stays as it was.
Status set_parameter(AnyBuilder& builder, std::string_view key, std::string_view value);

}  // namespace sightline::accel::published
