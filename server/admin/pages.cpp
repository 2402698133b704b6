// The pages of the admin port.
#include "server/admin/pages.h"

#include <utility>

namespace sightline::server::admin {
namespace {

constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

HttpReply ready_page(const Readiness& readiness) {
  const Status ready = readiness.check();
  if (ready) return {.body = "ready\n"};
  return {.code = 503, .body = ready.error().message};
}

}  // namespace

HttpServer::Handler pages(const Readiness& readiness, std::function<std::string()> metrics) {
  return [&readiness, metrics = std::move(metrics)](std::string_view path) -> HttpReply {
    if (path == kReadyPath) return ready_page(readiness);
    if (path == "/metrics") return {.body = metrics(), .type = kMetricsType};
    for (const PageFile& file : page_files()) {
      if (path == file.path)
        return {.body = std::string(file.content), .type = std::string(file.type)};
    }
    return {.code = 404,
            .body = "there are the live page at /, and /livez, /readyz and /metrics\n"};
  };
}

}  // namespace sightline::server::admin
