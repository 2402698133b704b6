// The certificates and the key of a server.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "proto/result.h"

namespace sightline::server::security {

/// PEM files. With no `certificate`: no TLS.
struct CertificateFiles {
  std::filesystem::path certificate;  ///< The server's, then those of its issuers.
  std::filesystem::path key;          ///< The key of the first certificate.
  std::filesystem::path client_ca;    ///< If set, clients need a certificate of this authority.

  bool empty() const { return certificate.empty(); }
  /// Whether they belong together. Errors: kInvalidArgument, reason CERTIFICATE_AND_KEY (one
  /// without the other, or `client_ca` without them).
  Status check() const;
};

/// What the files hold, as PEM.
struct Certificates {
  std::string chain = {};
  std::string key = {};
  std::string client_ca = {};
  std::chrono::sys_seconds expires =
      {};  ///< The server's certificate, which is the first of the chain.

  /// Errors, each naming the file: kFailedPrecondition (it cannot be read), kInvalidArgument (no
  /// certificate, no key, or the key of another certificate). An expired certificate is none.
  static Result<Certificates> read(const CertificateFiles& files);

  bool operator==(const Certificates&) const = default;
};

}  // namespace sightline::server::security
