// The one place where a builder is chosen at run time.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "accel/build/exact_builder.h"
#include "accel/build/median_builders.h"
#include "accel/build/min_max_builder.h"
#include "accel/build/scan_builder.h"
#include "accel/result.h"

namespace sightline::accel {

/// Made without a name it is a scan builder with its default parameters.
using AnyBuilder = std::variant<ScanBuilder, SpatialMedianBuilder, ObjectMedianBuilder,
                                ExactBuilder, MinMaxBuilder>;

/// What trees are grown by unless told otherwise: scan-fast.
AnyBuilder default_builder();

/// What trees are grown by that may last for one revision only: scan-one-axis, which builds in the
/// least time (docs/decisions/0018-frame-trees.md).
AnyBuilder frame_builder();

/// All names that make_builder knows, in the order of docs/builders.md.
std::vector<std::string_view> builder_names();

/// The builder of that name with its default parameters. Errors: kInvalidArgument, listing the
/// names.
Result<AnyBuilder> make_builder(std::string_view name);

/// Sets one parameter by name, e.g. ("samples", "8") or ("clip", "off"). Errors: kInvalidArgument:
/// no such parameter (listing them), not a number (a whole number, on or off), or out of range
/// (naming the range); the builder stays as it was.
Status set_parameter(AnyBuilder& builder, std::string_view key, std::string_view value);

/// Where the builder cuts a cell; nothing for a leaf.
std::optional<Cut> choose_cut(const AnyBuilder& builder, const CellRefs& cell,
                              BuildCounters& counters);

/// Whether the builder can look at a list through passes alone (CellRefs::run); the others need it
/// whole and at hand.
bool runs_passes(const AnyBuilder& builder);

/// Whether the builder wants the lists that come of sifting one of so many boxes counted meanwhile
/// (sift_and_scan), to be handed to it as CellRefs::first.
bool scans_children(const AnyBuilder& builder, std::size_t references);

/// For builders that scan children: where the first pass over the list of that cell counts.
FirstPlanes first_planes(const AnyBuilder& builder, const Aabb& child);

}  // namespace sightline::accel
