// The address that a server listens on.
#include "server/net/listen_address.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/un.h>

#include <charconv>

#include "server/exec/rpc_status.h"

namespace sightline::server::net {
namespace {

constexpr std::string_view kUnix = "unix:";
/// Bytes of the path of a Unix socket; the system wants a zero behind them.
constexpr std::size_t kMaxPath = sizeof(sockaddr_un::sun_path) - 1;

Error bad_address(std::string_view text, std::string_view form) {
  return {Code::kInvalidArgument, fmt::format("{} is not {}", exec::quote(text), form),
          "BAD_ADDRESS"};
}

Result<ListenAddress> parse_unix(std::string_view text) {
  const std::string_view path = text.substr(kUnix.size());
  if (path.empty() || path.size() > kMaxPath || path.find('\0') != std::string_view::npos)
    return bad_address(text, fmt::format("unix:PATH with a path of 1 to {} bytes", kMaxPath));
  return ListenAddress{.host = {}, .port = 0, .path = std::string(path)};
}

}  // namespace

Result<ListenAddress> ListenAddress::parse(std::string_view text) {
  if (text.starts_with(kUnix)) return parse_unix(text);
  const Error bad = bad_address(text, "HOST:PORT with a port from 0 to 65535");
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return bad;
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']') && host.size() > 2) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find_first_of(":[]") != std::string_view::npos) {
    return bad;
  }
  ListenAddress address{.host = std::string(host)};
  const char* end = port.data() + port.size();
  const auto [parsed_to, error] = std::from_chars(port.data(), end, address.port);
  if (host.empty() || error != std::errc{} || parsed_to != end) return bad;
  return address;
}

std::string ListenAddress::text() const {
  if (is_unix()) return fmt::format("{}{}", kUnix, path);
  const bool ipv6 = host.find(':') != std::string::npos;
  return ipv6 ? fmt::format("[{}]:{}", host, port) : fmt::format("{}:{}", host, port);
}

bool ListenAddress::is_local() const {
  if (is_unix()) return true;
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  in6_addr v6{};
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) return IN6_IS_ADDR_LOOPBACK(&v6);
  return host == "localhost";
}

}  // namespace sightline::server::net
