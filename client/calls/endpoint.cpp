// Addresses from text, and lists of them as gRPC has them.
#include "client/calls/endpoint.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string_view>

namespace sightline::client::calls {
namespace {

constexpr std::string_view kSocket = "unix:";
constexpr std::size_t kPortDigits = 5;

bool is_port(std::string_view text) {
  return !text.empty() && text.size() <= kPortDigits &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_v4(const std::string& host) {
  in_addr address{};
  return inet_pton(AF_INET, host.c_str(), &address) == 1;
}

bool is_v6(const std::string& host) {
  in6_addr address{};
  return inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

bool is_loopback(const std::string& host) {
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24U) == 127;
  in6_addr v6{};
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) return IN6_IS_ADDR_LOOPBACK(&v6);
  return host == "localhost";
}

/// The first address of a host in a family; nothing: it has none.
std::optional<std::string> resolve(const std::string& host, int family) {
  addrinfo hints{};
  hints.ai_family = family;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return std::nullopt;
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owned(found, freeaddrinfo);
  std::array<char, NI_MAXHOST> text{};
  if (getnameinfo(found->ai_addr, found->ai_addrlen, text.data(), text.size(), nullptr, 0,
                  NI_NUMERICHOST) != 0)
    return std::nullopt;
  return text.data();
}

}  // namespace

Result<Endpoint> Endpoint::parse(const std::string& text) {
  const Error bad{Code::kInvalidArgument,
                  fmt::format("endpoint '{}' is not HOST:PORT[,HOST:PORT...] or unix:PATH", text),
                  {}};
  Endpoint endpoint;
  endpoint.text_ = text;
  if (text.starts_with(kSocket)) {
    if (text.size() == kSocket.size()) return bad;
    return endpoint;
  }
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string address = text.substr(begin, end - begin);
    const std::size_t colon = address.rfind(':');
    if (colon == std::string::npos || colon == 0 || !is_port(address.substr(colon + 1))) return bad;
    std::string host = address.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
    endpoint.addresses_.push_back({host, address.substr(colon + 1)});
    begin = end + 1;
  }
  return endpoint;
}

bool Endpoint::is_local() const {
  return std::all_of(addresses_.begin(), addresses_.end(),
                     [](const Address& address) { return is_loopback(address.host); });
}

bool Endpoint::is_balanced() const {
  if (addresses_.size() != 1) return addresses_.size() > 1;
  const std::string& host = addresses_[0].host;
  return !is_loopback(host) && !is_v4(host) && !is_v6(host);
}

Result<std::string> Endpoint::target() const {
  if (addresses_.size() <= 1) return text_;
  // One list has addresses of one family.
  for (const int family : {AF_INET, AF_INET6}) {
    std::string target = family == AF_INET ? "ipv4:" : "ipv6:";
    bool has_all = true;
    for (const Address& address : addresses_) {
      const std::optional<std::string> host = resolve(address.host, family);
      has_all = has_all && host;
      if (!has_all) break;
      if (target.back() != ':') target += ',';
      target += family == AF_INET ? fmt::format("{}:{}", *host, address.port)
                                  : fmt::format("[{}]:{}", *host, address.port);
    }
    if (has_all) return target;
  }
  return Error{Code::kUnavailable,
               fmt::format("the hosts of '{}' do not all have an address of one family", text_),
               {}};
}

std::string Endpoint::authority() const {
  return addresses_.size() <= 1 ? std::string() : addresses_[0].host;
}

}  // namespace sightline::client::calls
