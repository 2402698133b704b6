// The report of a load test: one HTML file that needs nothing else.
#pragma once

#include <string>

#include "client/load/load_test.h"
#include "client/load/result_json.h"

namespace sightline::client::load::report {

/// The whole page. It loads nothing and runs no script.
std::string make_page(const LoadOptions& options, const LoadContext& context,
                      const LoadResult& result);

}  // namespace sightline::client::load::report
