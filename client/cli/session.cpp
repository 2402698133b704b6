// Makes connections from flags, and JSON from values.
#include "client/cli/session.h"

#include <chrono>
#include <cmath>
#include <cstdio>

namespace sightline::client::cli {

Result<Client> Session::connect() const {
  ClientOptions options;
  if (deadline) {
    options.timeout = std::chrono::milliseconds(std::llround(std::ceil(*deadline * 1000)));
  }
  return Client::connect(endpoint, options);
}

void print_json(const Json& document) {
  const std::string text = document.dump(2, ' ', false, Json::error_handler_t::replace);
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fputc('\n', stdout);
}

Json json_of_axis(UpAxis axis) {
  if (axis == UpAxis::kY) return "y";
  if (axis == UpAxis::kZ) return "z";
  return nullptr;
}

Json json_of_unit(double meters_per_unit) {
  return meters_per_unit > 0 ? Json(meters_per_unit) : Json(nullptr);
}

}  // namespace sightline::client::cli
