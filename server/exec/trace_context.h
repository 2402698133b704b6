// The trace that a call belongs to: W3C Trace Context, header traceparent.
#pragma once

#include <string_view>

namespace sightline::server::exec {

/// The metadata by which a client says what trace a call belongs to.
inline constexpr const char* kTraceParent = "traceparent";

/// The trace id, 32 small hexadecimal digits, of a header of that name. Empty where the header is
/// not as W3C Trace Context (2021) section 3.2 says, and is to be ignored.
std::string_view parse_trace_id(std::string_view traceparent);

}  // namespace sightline::server::exec
