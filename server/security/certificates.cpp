// The certificates and the key of a server.
#include "server/security/certificates.h"

#include <fmt/format.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <ctime>
#include <memory>

#include "server/security/read_file.h"

namespace sightline::server::security {
namespace {

constexpr std::size_t kMaxFile = std::size_t{4} << 20;

struct Free {
  void operator()(BIO* bio) const { BIO_free(bio); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};
using Bio = std::unique_ptr<BIO, Free>;
using Certificate = std::unique_ptr<X509, Free>;
using Key = std::unique_ptr<EVP_PKEY, Free>;

Error bad_file(const std::filesystem::path& file, const char* what) {
  ERR_clear_error();
  return {Code::kInvalidArgument, fmt::format("{} {}", file.string(), what), "BAD_CERTIFICATE"};
}

Bio bio_of(const std::string& pem) {
  return Bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

/// A key with a password is not accepted: OpenSSL would ask for it at the terminal.
int no_password(char*, int, int, void*) { return -1; }

Certificate first_certificate(const std::string& pem) {
  return Certificate(PEM_read_bio_X509(bio_of(pem).get(), nullptr, no_password, nullptr));
}

std::chrono::sys_seconds expiry_of(const X509& certificate) {
  std::tm broken_down{};
  ASN1_TIME_to_tm(X509_get0_notAfter(&certificate), &broken_down);
  return std::chrono::sys_seconds(std::chrono::seconds(timegm(&broken_down)));
}

}  // namespace

Status CertificateFiles::check() const {
  if (certificate.empty() == key.empty() && (client_ca.empty() || !certificate.empty())) return {};
  return Error{Code::kInvalidArgument,
               "--tls-cert and --tls-key need each other, and --tls-client-ca needs both",
               "CERTIFICATE_AND_KEY"};
}

Result<Certificates> Certificates::read(const CertificateFiles& files) {
  auto chain = read_file(files.certificate, kMaxFile);
  if (!chain) return chain.error();
  auto key = read_file(files.key, kMaxFile);
  if (!key) return key.error();
  Certificates made{.chain = *std::move(chain), .key = *std::move(key)};
  const Certificate own = first_certificate(made.chain);
  if (own == nullptr) return bad_file(files.certificate, "has no certificate in PEM form");
  const Key own_key(PEM_read_bio_PrivateKey(bio_of(made.key).get(), nullptr, no_password, nullptr));
  if (own_key == nullptr)
    return bad_file(files.key, "has no private key in PEM form, or one with a password");
  if (X509_check_private_key(own.get(), own_key.get()) != 1)
    return bad_file(files.key, "is not the key of the certificate");
  made.expires = expiry_of(*own);
  if (files.client_ca.empty()) return made;
  auto client_ca = read_file(files.client_ca, kMaxFile);
  if (!client_ca) return client_ca.error();
  made.client_ca = *std::move(client_ca);
  if (first_certificate(made.client_ca) == nullptr)
    return bad_file(files.client_ca, "has no certificate in PEM form");
  return made;
}

}  // namespace sightline::server::security
