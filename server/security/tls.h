// TLS of a server: its certificates, and the credentials that gRPC takes them from.
#pragma once

#include <grpcpp/security/server_credentials.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <string>

#include "proto/result.h"
#include "server/security/certificates.h"

namespace sightline::server::security {

/// Connections get the certificates that are valid when they are made. Threads: any, for every
/// member.
class Tls {
 public:
  /// Errors: see Certificates::read().
  static Result<std::unique_ptr<Tls>> make(const CertificateFiles& files);

  /// Reads the files again. Files that cannot be used, such as a key whose certificate is not there
  /// yet, change nothing, and are logged once. Errors: as make().
  Status reload();

  /// Credentials for one server, which must not accept connections after the end of this object.
  std::shared_ptr<grpc::ServerCredentials> credentials();

  std::chrono::sys_seconds expires() const;  ///< When the server's certificate expires.

 private:
  friend class ReloadedCredentials;
  Tls(CertificateFiles files, Certificates certificates);

  /// Takes what is to be used from now on; false if that is what was used before.
  bool take_new(Certificates& certificates);

  const CertificateFiles files_;
  std::string complained_;  // used by reload() alone
  mutable std::mutex mutex_;
  Certificates certificates_;
  bool is_new_ = true;
};

}  // namespace sightline::server::security
