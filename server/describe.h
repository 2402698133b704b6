// What sightlined takes on its command line, for pages that describe it.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace sightline::server {

/// Passes the flags to `read`. Defaults that depend on the machine are words.
void describe_flags(const std::function<void(const CLI::App&)>& read);
/// Passes the flags of `sightlined doctor` to `read`.
void describe_doctor_flags(const std::function<void(const CLI::App&)>& read);

}  // namespace sightline::server
