// Makes connections from flags, and JSON from values.
#include "client/cli/session.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

namespace sightline::client::cli {
namespace {

constexpr const char* kBlank = " \t\r\n";

/// The text of the file without blanks around it, or the variable of the environment.
Result<std::string> read_token(const std::string& file) {
  if (file.empty()) {
    const char* const variable = std::getenv("SIGHTLINE_TOKEN");  // NOLINT(concurrency-mt-unsafe)
    return std::string(variable != nullptr ? variable : "");
  }
  std::ifstream in(file);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  const std::size_t first = text.find_first_not_of(kBlank);
  if (!in || first == std::string::npos)
    return local_error(fmt::format("cannot read a token from {}", file));
  return text.substr(first, text.find_last_not_of(kBlank) + 1 - first);
}

}  // namespace

Result<Client> Session::connect() const {
  ClientOptions all = options;
  if (deadline) all.timeout = std::chrono::milliseconds(std::llround(std::ceil(*deadline * 1000)));
  auto token = read_token(token_file);
  if (!token) return token.error();
  all.token = *std::move(token);
  return Client::connect(endpoint, all);
}

std::string json_text(const Json& document, int indent) {
  const std::string text = document.dump(indent, ' ', false, Json::error_handler_t::replace);
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : '\0');
    if (byte == 0x7f) {
      out += "\\u007f";
    } else if (byte == 0xc2 && next < 0xa0) {  // U+0080 to U+009F
      out += fmt::format("\\u{:04x}", next);
      ++i;
    } else {
      out += text[i];
    }
  }
  return out;
}

void print_json(const Json& document) {
  const std::string text = json_text(document, 2);
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
