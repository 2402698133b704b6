// What a server's TLS shows and asks for, and how its files are replaced.
#include "server/security/tls.h"

#include <gtest/gtest.h>
#include <openssl/ssl.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <string>

#include "tests/client/support/temp_dir.h"
#include "tests/server/support/asking_server.h"
#include "tests/server/support/tls_greeting.h"
#include "tests/support/certificates.h"

namespace sightline::server::security {
namespace {

using tests::AskingServer;
using tests::greet_by_tls;

Result<std::string> answer_hello(exec::CallContext&) { return std::string("hello"); }

class TlsTest : public testing::Test {
 protected:
  TlsTest() {
    spdlog::set_level(spdlog::level::off);
    write(own_);
  }

  void write(const tests::TestCertificate& pair) const {
    dir_.write("own.pem", pair.certificate);
    dir_.write("own.key", pair.key);
  }
  std::unique_ptr<Tls> make() const {
    auto made = Tls::make(files_);
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }
  /// As a client with a certificate of this authority; null: with none.
  std::shared_ptr<grpc::ChannelCredentials> client(const tests::TestAuthority* authority) const {
    if (authority == nullptr) return grpc::SslCredentials({authority_.certificate(), {}, {}});
    const tests::TestCertificate own = authority->issue({.name = "robot"});
    return grpc::SslCredentials({authority_.certificate(), own.key, own.certificate});
  }

  const tests::TempDir dir_;
  const tests::TestAuthority authority_, clients_{"Client CA"};
  const tests::TestCertificate own_ = authority_.issue();
  CertificateFiles files_{
      .certificate = dir_.path("own.pem"), .key = dir_.path("own.key"), .client_ca = {}};
  exec::CallContexts calls_;
};

TEST_F(TlsTest, WithoutAnAuthorityOfClientsNoneIsAsked) {
  const auto tls = make();
  const AskingServer server(calls_, answer_hello, "127.0.0.1:0", tls->credentials());
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
    const tests::TlsGreeting greeting = greet_by_tls(server.port(), version);
    EXPECT_TRUE(greeting.done);
    EXPECT_FALSE(greeting.asked);
    EXPECT_EQ(greeting.certificate, own_.certificate);
  }
  EXPECT_EQ(tests::ask(server.connect(client(nullptr))), "hello");
  // A certificate that the client would offer is not asked for.
  EXPECT_EQ(tests::ask(server.connect(client(&clients_))), "hello");
}

TEST_F(TlsTest, WithAnAuthorityOfClientsAllAreAsked) {
  files_.client_ca = dir_.write("clients.pem", clients_.certificate());
  const auto tls = make();
  const AskingServer server(calls_, answer_hello, "127.0.0.1:0", tls->credentials());
  const tests::TlsGreeting greeting = greet_by_tls(server.port(), TLS1_2_VERSION);
  EXPECT_TRUE(greeting.asked);
  EXPECT_FALSE(greeting.done);
  EXPECT_EQ(tests::ask(server.connect(client(&clients_))), "hello");
}

TEST_F(TlsTest, OldVersionsAreRefused) {
  const auto tls = make();
  const AskingServer server(calls_, answer_hello, "127.0.0.1:0", tls->credentials());
  for (const int version : {TLS1_VERSION, TLS1_1_VERSION}) {
    const tests::TlsGreeting greeting = greet_by_tls(server.port(), version);
    EXPECT_FALSE(greeting.done);
    EXPECT_TRUE(greeting.hung_up);
  }
}

TEST_F(TlsTest, NewConnectionsGetWhatIsValidThen) {
  const auto tls = make();
  const AskingServer server(calls_, answer_hello, "127.0.0.1:0", tls->credentials());
  EXPECT_EQ(greet_by_tls(server.port(), TLS1_3_VERSION).certificate, own_.certificate);
  const tests::TestCertificate fresh = authority_.issue();
  write(fresh);
  EXPECT_EQ(greet_by_tls(server.port(), TLS1_3_VERSION).certificate, own_.certificate);
  EXPECT_TRUE(tls->reload());
  EXPECT_EQ(greet_by_tls(server.port(), TLS1_3_VERSION).certificate, fresh.certificate);
}

TEST_F(TlsTest, FilesThatDoNotFitChangeNothing) {
  const auto tls = make();
  const auto expires = tls->expires();
  const auto late = authority_.issue({.valid_for = std::chrono::hours(48)});
  dir_.write("own.pem", late.certificate);
  EXPECT_FALSE(tls->reload());
  EXPECT_EQ(tls->expires(), expires);
  dir_.write("own.key", late.key);
  EXPECT_TRUE(tls->reload());
  EXPECT_GT(tls->expires(), expires + std::chrono::hours(24));
}

TEST_F(TlsTest, StartsOnlyWithFilesThatFit) {
  dir_.write("own.key", authority_.issue().key);
  const auto made = Tls::make(files_);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, Code::kInvalidArgument);
}

}  // namespace
}  // namespace sightline::server::security
