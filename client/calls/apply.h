// Sends updates as single requests, each applied at most once. Internal to the library.
#pragma once

#include <span>
#include <string>

#include "client/result.h"
#include "client/update.h"

namespace sightline::client::calls {

struct Connection;

Result<Applied> apply(const Connection& connection, const std::string& scene,
                      std::span<const Update> updates, const ApplyOptions& options);
Result<Applied> apply_in_batches(const Connection& connection, const std::string& scene,
                                 std::span<const Update> updates, const ApplyOptions& options);

}  // namespace sightline::client::calls
