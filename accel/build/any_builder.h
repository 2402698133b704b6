// The one place where a builder is chosen at run time.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "accel/build/scan_builder.h"
#include "accel/result.h"

namespace sightline::accel {

using AnyBuilder = std::variant<ScanBuilder>;

/// All names that make_builder knows, in the order of docs/builders.md.
std::vector<std::string_view> builder_names();

/// The builder of that name with its default parameters. Errors: kInvalidArgument, listing the names.
Result<AnyBuilder> make_builder(std::string_view name);

/// Sets one parameter by name, e.g. ("samples", "8"). Errors: kInvalidArgument: no such parameter (listing them), not a
/// number, or out of range (naming the range).
Status set_parameter(AnyBuilder& builder, std::string_view key, std::string_view value);

}  // namespace sightline::accel
