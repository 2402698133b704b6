// Who may connect: the address, TLS, and tokens.
#include "server/access.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <string>
#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server {

Result<net::ListenAddress> check_listen(const ServerConfig& config) {
  auto address = net::ListenAddress::parse(config.listen);
  if (!address || address->is_local() || !config.tls.empty() || config.insecure) return address;
  return Error{Code::kInvalidArgument,
               fmt::format("{} can be reached from other machines: encrypt with --tls-cert and "
                           "--tls-key, listen on a loopback address, or allow it with --insecure",
                           config.listen),
               "INSECURE_ADDRESS"};
}

void warn_if_exposed(const ServerConfig& config, const net::ListenAddress& address) {
  if (address.is_local()) return;
  if (config.tls.empty()) spdlog::warn("event=not_encrypted listen={}", config.listen);
  if (config.tokens.empty() && config.tls.client_ca.empty())
    spdlog::warn("event=not_authenticated every client may do everything listen={}", config.listen);
}

Result<Access> Access::make(const ServerConfig& config) {
  Access access;
  if (!config.tls.empty()) {
    auto tls = security::Tls::make(config.tls);
    if (!tls) return tls.error();
    access.tls = *std::move(tls);
  }
  const bool certified = !config.tls.client_ca.empty();
  auto authenticator = security::Authenticator::make(config.tokens, certified);
  if (!authenticator) return authenticator.error();
  access.authenticator = *std::move(authenticator);
  return access;
}

void Access::reload(bool asked) const {
  const Status reloaded = exec::to_status([this, asked] {
    const Status certificates = tls != nullptr ? tls->reload() : Status();
    const Status tokens = authenticator->reload();
    if (asked) {
      const auto outcome = [](bool is_used, const Status& read) {
        if (!is_used) return std::string("none");
        return read ? "read" : "kept error=" + exec::quote(read.error().message);
      };
      spdlog::info("event=reloaded certificates={} tokens={}",
                   outcome(tls != nullptr, certificates),
                   outcome(authenticator->has_tokens(), tokens));
    }
    return Status();
  });
  if (!reloaded)
    spdlog::error("event=not_reloaded error={}", exec::quote(reloaded.error().message));
}

}  // namespace sightline::server
