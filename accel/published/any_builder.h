// The one place where a builder is chosen at run time.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "accel/published/bvh/bvh_builder.h"
#include "accel/result.h"
#include "accel/split/kd_builder.h"

namespace sightline::accel::published {

/// What a mesh's tree is made by. Trees over a scene's nodes are kd-trees, whatever their meshes
/// have.
using AnyBuilder = std::variant<split::KdBuilder, bvh::BvhBuilder>;

/// What trees are grown by unless told otherwise: scan-fast.
split::KdBuilder default_builder();

/// What trees are grown by that may last for one revision only: scan-one-axis, which builds in the
/// least time (docs/decisions/0018-frame-trees.md).
split::KdBuilder frame_builder();

/// All names that make_builder knows, in the order of docs/builders.md: kd-trees first.
std::vector<std::string_view> builder_names();

/// The builder of that name with its default parameters. Errors: kInvalidArgument, listing the
/// names.
Result<AnyBuilder> make_builder(std::string_view name);

/// Sets one parameter by name, e.g. ("samples", "8") or ("clip", "off"). Errors: kInvalidArgument:
/// no such parameter (listing them), not a number (a whole number, on or off), or out of range
/// (naming the range); the builder stays as it was.
Status set_parameter(AnyBuilder& builder, std::string_view key, std::string_view value);

}  // namespace sightline::accel::published
