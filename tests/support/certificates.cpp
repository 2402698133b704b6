// Certificates that are made while a test runs.
#include "tests/support/certificates.h"

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <cstdint>
#include <cstdlib>

namespace sightline::tests {
namespace {

struct Free {
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
  void operator()(BIO* bio) const { BIO_free(bio); }
};
using Certificate = std::unique_ptr<X509, Free>;
using Key = std::unique_ptr<EVP_PKEY, Free>;

constexpr std::chrono::hours kAge{1};

void must(bool done) {
  if (!done) std::abort();
}

template <class Write>
std::string written(Write write) {
  const std::unique_ptr<BIO, Free> bio(BIO_new(BIO_s_mem()));
  must(write(bio.get()) == 1);
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

std::string pem_of(X509& certificate) {
  return written([&](BIO* bio) { return PEM_write_bio_X509(bio, &certificate); });
}

std::string pem_of(EVP_PKEY& key) {
  return written([&](BIO* bio) {
    return PEM_write_bio_PrivateKey(bio, &key, nullptr, nullptr, 0, nullptr, nullptr);
  });
}

void extend(X509& certificate, int id, const std::string& value) {
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, nullptr, id, value.c_str());
  must(extension != nullptr && X509_add_ext(&certificate, extension, -1) == 1);
  X509_EXTENSION_free(extension);
}

/// With a name, a serial number, times and a public key, but not signed.
Certificate unsigned_certificate(const std::string& name, std::chrono::seconds valid_for,
                                 EVP_PKEY& key) {
  Certificate made(X509_new());
  must(X509_set_version(made.get(), 2) == 1);
  std::uint32_t serial = 0;
  must(RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) == 1);
  ASN1_INTEGER_set_uint64(X509_get_serialNumber(made.get()), serial);
  X509_gmtime_adj(X509_getm_notBefore(made.get()), -std::chrono::seconds(kAge).count());
  X509_gmtime_adj(X509_getm_notAfter(made.get()), valid_for.count());
  must(X509_NAME_add_entry_by_txt(X509_get_subject_name(made.get()), "CN", MBSTRING_UTF8,
                                  reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1,
                                  0) == 1);
  must(X509_set_pubkey(made.get(), &key) == 1);
  return made;
}

}  // namespace

struct TestAuthority::Signer {
  Key key;
  Certificate certificate;

  void sign(X509& other) const {
    X509_set_issuer_name(&other, X509_get_subject_name(certificate.get()));
    must(X509_sign(&other, key.get(), EVP_sha256()) > 0);
  }
};

TestAuthority::TestAuthority(const std::string& name) : signer_(std::make_unique<Signer>()) {
  signer_->key.reset(EVP_EC_gen("P-256"));
  signer_->certificate = unsigned_certificate(name, std::chrono::hours(1), *signer_->key);
  extend(*signer_->certificate, NID_basic_constraints, "critical,CA:TRUE");
  extend(*signer_->certificate, NID_key_usage, "critical,keyCertSign,cRLSign");
  signer_->sign(*signer_->certificate);
  pem_ = pem_of(*signer_->certificate);
}

TestAuthority::~TestAuthority() = default;

TestCertificate TestAuthority::issue(const TestSubject& subject) const {
  const Key key(EVP_EC_gen("P-256"));
  const Certificate made = unsigned_certificate(subject.name, subject.valid_for, *key);
  extend(*made, NID_subject_alt_name, subject.alternatives);
  signer_->sign(*made);
  return {pem_of(*made), pem_of(*key)};
}

}  // namespace sightline::tests
