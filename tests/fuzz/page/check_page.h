// Checks that the admin port bears what a page sends.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/fuzz/page/page_session.h"

namespace sightline::tests {

/// Sends the steps through a WebSocket to a server of this process, and reads the rest of what it
/// answers. Describes an error, or nothing: the server does not close the connection, or does not
/// answer another page afterwards.
std::optional<std::string> check_page(const std::vector<PageStep>& steps);

}  // namespace sightline::tests
