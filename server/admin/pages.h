// The pages of the admin port.
#pragma once

#include <functional>
#include <string>

#include "server/admin/http_server.h"
#include "server/admin/readiness.h"

namespace sightline::server::admin {

/// The pages /livez (the process answers), /readyz (200, or 503 and the reasons) and /metrics
/// (Prometheus' text format). `readiness` outlives the handler; `metrics` makes the text.
HttpServer::Handler pages(const Readiness& readiness, std::function<std::string()> metrics);

}  // namespace sightline::server::admin
