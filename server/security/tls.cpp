// TLS of a server: its certificates, and the credentials that gRPC takes them from.
#include "server/security/tls.h"

#include <fmt/chrono.h>
#include <grpc/grpc.h>
#include <grpc/grpc_security.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::security {
namespace {

void log_loaded(const Certificates& certificates) {
  const auto expires = std::chrono::system_clock::to_time_t(certificates.expires);
  spdlog::info("event=certificates_loaded expires={:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(expires));
  if (certificates.expires <= std::chrono::system_clock::now())
    spdlog::error("event=certificate_expired clients will refuse this server");
}

}  // namespace

/// gRPC's C library asks for certificates at each handshake. The C++ library's own credentials do
/// not offer that.
class ReloadedCredentials final : public grpc::ServerCredentials {
 public:
  ReloadedCredentials(Tls& tls, bool client_certificates)
      : credentials_(grpc_ssl_server_credentials_create_with_options(
            grpc_ssl_server_credentials_create_options_using_config_fetcher(
                client_certificates ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                                    : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE,
                fetch, &tls))) {}
  ReloadedCredentials(const ReloadedCredentials&) = delete;
  ReloadedCredentials& operator=(const ReloadedCredentials&) = delete;
  ~ReloadedCredentials() override { grpc_server_credentials_release(credentials_); }

  /// A processor is not used: it sees no requests, and its errors have no details.
  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  static grpc_ssl_certificate_config_reload_status fetch(
      void* tls, grpc_ssl_server_certificate_config** config) {
    Certificates certificates;
    if (!static_cast<Tls*>(tls)->take_new(certificates))
      return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    const grpc_ssl_pem_key_cert_pair pair{certificates.key.c_str(), certificates.chain.c_str()};
    // gRPC 1.51 asserts that there are roots. Where no client is asked, none is held against them.
    const std::string& roots =
        certificates.client_ca.empty() ? certificates.chain : certificates.client_ca;
    *config = grpc_ssl_server_certificate_config_create(roots.c_str(), &pair, 1);
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }

  grpc_server_credentials* const credentials_;
};

Tls::Tls(CertificateFiles files, Certificates certificates)
    : files_(std::move(files)), certificates_(std::move(certificates)) {
  log_loaded(certificates_);
}

Result<std::unique_ptr<Tls>> Tls::make(const CertificateFiles& files) {
  auto certificates = Certificates::read(files);
  if (!certificates) return certificates.error();
  return std::unique_ptr<Tls>(new Tls(files, *std::move(certificates)));
}

Status Tls::reload() {
  auto read = Certificates::read(files_);
  std::string complaint = read ? std::string() : read.error().message;
  if (!complaint.empty() && complaint != complained_)
    spdlog::error("event=certificates_not_loaded kept=old error={}", exec::quote(complaint));
  complained_ = std::move(complaint);
  if (!read) return read.error();
  const std::lock_guard lock(mutex_);
  if (*read == certificates_) return {};
  log_loaded(*read);
  certificates_ = *std::move(read);
  is_new_ = true;
  return {};
}

bool Tls::take_new(Certificates& certificates) {
  const std::lock_guard lock(mutex_);
  if (is_new_) certificates = certificates_;
  return std::exchange(is_new_, false);
}

std::shared_ptr<grpc::ServerCredentials> Tls::credentials() {
  return std::make_shared<ReloadedCredentials>(*this, !files_.client_ca.empty());
}

std::chrono::sys_seconds Tls::expires() const {
  const std::lock_guard lock(mutex_);
  return certificates_.expires;
}

}  // namespace sightline::server::security
