// Which files make the certificates of a server.
#include "server/security/certificates.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "tests/client/support/temp_dir.h"
#include "tests/support/certificates.h"

namespace sightline::server::security {
namespace {

class CertificatesTest : public testing::Test {
 protected:
  CertificatesTest() { write(own_); }

  void write(const tests::TestCertificate& pair) const {
    dir_.write("own.pem", pair.certificate);
    dir_.write("own.key", pair.key);
  }

  /// The error of reading them, which must name this file.
  Error error_naming(const std::string& file) const {
    const auto read = Certificates::read(files_);
    if (read) {
      ADD_FAILURE() << "read, though " << file << " is bad";
      return {};
    }
    EXPECT_NE(read.error().message.find(dir_.path(file)), std::string::npos)
        << read.error().message;
    return read.error();
  }

  const tests::TempDir dir_;
  const tests::TestAuthority authority_;
  const tests::TestCertificate own_ = authority_.issue();
  CertificateFiles files_{
      .certificate = dir_.path("own.pem"), .key = dir_.path("own.key"), .client_ca = {}};
};

TEST_F(CertificatesTest, AreWhatTheFilesHold) {
  files_.client_ca = dir_.write("clients.pem", authority_.certificate());
  const auto read = Certificates::read(files_);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->chain, own_.certificate);
  EXPECT_EQ(read->key, own_.key);
  EXPECT_EQ(read->client_ca, authority_.certificate());
  EXPECT_EQ(*read, *Certificates::read(files_));
}

TEST_F(CertificatesTest, TellWhenTheFirstOfTheChainExpires) {
  const auto now = std::chrono::system_clock::now();
  const auto past = authority_.issue({.valid_for = std::chrono::hours(-1)});
  dir_.write("own.pem", past.certificate + authority_.certificate());
  dir_.write("own.key", past.key);
  const auto read = Certificates::read(files_);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_LT(read->expires, now);
  EXPECT_GT(read->expires, now - std::chrono::hours(2));
}

TEST_F(CertificatesTest, NeedTheKeyOfTheCertificate) {
  dir_.write("own.key", authority_.issue().key);
  EXPECT_EQ(error_naming("own.key").code, Code::kInvalidArgument);
  dir_.write("own.key", own_.certificate);
  EXPECT_EQ(error_naming("own.key").code, Code::kInvalidArgument);
  dir_.write("own.key", "");
  EXPECT_EQ(error_naming("own.key").code, Code::kInvalidArgument);
}

TEST_F(CertificatesTest, AreInPemForm) {
  dir_.write("own.pem", own_.key);
  EXPECT_EQ(error_naming("own.pem").code, Code::kInvalidArgument);
  dir_.write("own.pem", own_.certificate.substr(0, own_.certificate.size() / 2));
  EXPECT_EQ(error_naming("own.pem").code, Code::kInvalidArgument);
  write(own_);
  files_.client_ca = dir_.write("clients.pem", "no certificate");
  EXPECT_EQ(error_naming("clients.pem").code, Code::kInvalidArgument);
}

TEST_F(CertificatesTest, ComeFromFilesThatCanBeRead) {
  files_.client_ca = dir_.path("none.pem");
  EXPECT_EQ(error_naming("none.pem").code, Code::kFailedPrecondition);
  std::filesystem::remove(files_.key);
  EXPECT_EQ(error_naming("own.key").code, Code::kFailedPrecondition);
  std::filesystem::remove(files_.certificate);
  std::filesystem::create_directory(files_.certificate);
  EXPECT_EQ(error_naming("own.pem").code, Code::kFailedPrecondition);
}

}  // namespace
}  // namespace sightline::server::security
