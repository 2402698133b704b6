// Messages to the service manager that has started the program (sd_notify(3)).
#pragma once

#include <string_view>

namespace sightline::server {

/// Sends "READY=1", "STOPPING=1", or lines of them. Without a manager that listens (NOTIFY_SOCKET
/// is not set) nothing is done. Never waits; what cannot be sent is lost.
void tell_service_manager(std::string_view state);

}  // namespace sightline::server
