// Whether a text is strict JSON, before messages are made of it.
#pragma once

#include <cstddef>
#include <string_view>

#include "proto/result.h"

namespace sightline::server::admin {

/// Objects and arrays inside each other at most.
inline constexpr std::size_t kMaxJsonDepth = 32;

/// Whether `text` is one object of JSON (RFC 8259) in UTF-8, at most kMaxJsonDepth deep, of which
/// no object has a name twice. "upAxis" and "up_axis" are one name, as they are to messages.
/// Protobuf's own reader takes more than JSON, and of two values the last. Errors:
/// kInvalidArgument.
Status check_json(std::string_view text);

}  // namespace sightline::server::admin
