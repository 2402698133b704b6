// Checks what the server promises, whatever a client sends.
#pragma once

#include <optional>
#include <string>

#include "tests/fuzz/service/session.h"

namespace sightline::tests {

/// Makes the calls at a server of this process, one after the other. Describes an error, or
/// nothing: a call that does not end, a status that blames the server, an error without a reason,
/// or a wrong answer to another client afterwards.
std::optional<std::string> check_session(const Session& session);

/// Gives the messages to the decoders, without a server. Describes an error, or nothing: a value
/// that is not the same after it is encoded and decoded again.
std::optional<std::string> check_decoders(const Session& session);

}  // namespace sightline::tests
