// The address that a server listens on.
#include "server/net/listen_address.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <charconv>

#include "server/exec/rpc_status.h"

namespace sightline::server::net {

Result<ListenAddress> ListenAddress::parse(std::string_view text) {
  const Error bad{Code::kInvalidArgument,
                  fmt::format("{} is not HOST:PORT with a port from 0 to 65535", exec::quote(text)),
                  "BAD_ADDRESS"};
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return bad;
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']') && host.size() > 2) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find_first_of(":[]") != std::string_view::npos) {
    return bad;
  }
  ListenAddress address{std::string(host), 0};
  const char* end = port.data() + port.size();
  const auto [parsed_to, error] = std::from_chars(port.data(), end, address.port);
  if (host.empty() || error != std::errc{} || parsed_to != end) return bad;
  return address;
}

std::string ListenAddress::text() const {
  const bool ipv6 = host.find(':') != std::string::npos;
  return ipv6 ? fmt::format("[{}]:{}", host, port) : fmt::format("{}:{}", host, port);
}

bool ListenAddress::is_loopback() const {
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  in6_addr v6{};
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) return IN6_IS_ADDR_LOOPBACK(&v6);
  return host == "localhost";
}

}  // namespace sightline::server::net
