// Certificates that are made while a test runs.
#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace sightline::tests {

/// PEM texts.
struct TestCertificate {
  std::string certificate;
  std::string key;
};

/// What a certificate says. By default a server of this machine, valid since an hour ago.
struct TestSubject {
  std::string name = "localhost";
  std::string alternatives = "DNS:localhost,IP:127.0.0.1,IP:::1";  ///< As OpenSSL writes them.
  std::chrono::seconds valid_for = std::chrono::hours(1);          ///< From now; may be negative.
};

/// An authority that signs certificates, with a key of its own.
class TestAuthority {
 public:
  explicit TestAuthority(const std::string& name = "Test CA");
  ~TestAuthority();

  const std::string& certificate() const { return pem_; }
  TestCertificate issue(const TestSubject& subject = {}) const;

 private:
  struct Signer;
  std::unique_ptr<Signer> signer_;
  std::string pem_;
};

}  // namespace sightline::tests
