// The calls of live pages: from WebSockets to the server's own services, within the process.
#include "server/admin/tunnel.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "server/admin/tunnel_call.h"
#include "server/exec/rpc_status.h"

namespace sightline::server::admin {
namespace {

/// The host without its port.
std::string host_name(std::string_view host) {
  if (host.starts_with('[')) return std::string(host.substr(1, host.find(']') - 1));
  return std::string(host.substr(0, host.find(':')));
}

/// Whether the name is an address: an attacker can make a DNS name lead here, but no address.
bool is_address(const std::string& name) {
  std::array<unsigned char, sizeof(in6_addr)> parsed;
  return name == "localhost" || inet_pton(AF_INET, name.c_str(), parsed.data()) == 1 ||
         inet_pton(AF_INET6, name.c_str(), parsed.data()) == 1;
}

Error denied(std::string message) {
  return {Code::kPermissionDenied, std::move(message), "PAGE_REFUSED"};
}

}  // namespace

Status Tunnel::check_page(std::string_view origin, std::string_view host) const {
  if (access_.certificates && !access_.tokens)
    return denied(
        "this server knows its clients by certificates, which the page has none of: give it "
        "--tokens");
  if (!origin.empty() && origin != fmt::format("http://{}", host) &&
      origin != fmt::format("https://{}", host))
    return denied(fmt::format("a page from {} may not use this server", exec::quote(origin)));
  if (!access_.tokens && !is_address(host_name(host)))
    return denied("without --tokens the page is served under an address, not under a name");
  return {};
}

Status Tunnel::admit(std::string_view origin, std::string_view host, const std::string& address) {
  if (Status good = check_page(origin, host); !good) return good;
  if (free_slot_for(address)) return {};
  return Error{Code::kResourceExhausted, fmt::format("{} pages are open already", kMaxSockets),
               "TOO_MANY_PAGES"};
}

bool Tunnel::free_slot_for(const std::string& address) {
  if (pages_.size() < kMaxSockets) return true;
  std::map<std::string, std::size_t> of_address;
  for (const Page& page : pages_) ++of_address[page.address];
  const auto newest_of_most = std::max_element(
      pages_.rbegin(), pages_.rend(),
      [&](const Page& a, const Page& b) { return of_address[a.address] < of_address[b.address]; });
  if (of_address[newest_of_most->address] < of_address[address] + 2) return false;
  const auto close = newest_of_most->close;  // the page leaves the list, now or soon
  close();
  return true;
}

void Tunnel::stop() {
  const std::lock_guard lock(opening_);
  stopped_ = true;
}

void Tunnel::end_calls() {
  stop();
  std::unique_lock lock(mutex_);
  for (TunnelCall* call : calls_) call->cancel();
  changed_.wait(lock, [this] { return calls_.empty(); });
}

}  // namespace sightline::server::admin
