// What a client may send to the public port, as HTTP/2 or not.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace sightline::tests {

/// Gives the bytes to a guard in pieces, and to a gRPC server of this process behind one, after a
/// client's greeting where the first is even. Describes an error, or nothing: a verdict that
/// depends on the pieces, or a connection that does not end with what was sent.
std::optional<std::string> check_port(std::span<const std::uint8_t> bytes);

}  // namespace sightline::tests
