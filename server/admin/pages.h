// The pages of the admin port.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "server/admin/http_server.h"
#include "server/admin/readiness.h"

namespace sightline::server::admin {

/// A file of the live page.
struct PageFile {
  std::string_view path;  ///< "/page/viewer.js"; the first page is "/".
  std::string_view type;
  std::string_view content;
};
/// All files of the live page; they are part of the program.
std::span<const PageFile> page_files();

/// The live page, and the pages /readyz (200, or 503 and the reasons) and /metrics (Prometheus'
/// text format). `readiness` outlives the handler; `metrics` makes the text.
HttpServer::Handler pages(const Readiness& readiness, std::function<std::string()> metrics);

}  // namespace sightline::server::admin
