// Who calls, by the headers and the certificates of clients.
#include "server/security/authenticator.h"

#include <grpcpp/security/credentials.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>
#include <string>

#include "tests/client/support/temp_dir.h"
#include "tests/server/support/asking_server.h"
#include "tests/server/support/token_file.h"
#include "tests/support/certificates.h"

namespace sightline::server::security {
namespace {

using tests::ask;
using tests::AskingServer;
using tests::token_row;

/// Answers with the name of the call's principal, or "anonymous".
AskingServer::Answer names_by(Authenticator& authenticator) {
  return [&authenticator](exec::CallContext& context) -> Result<std::string> {
    const Status known = authenticator.authenticate(context);
    if (!known) return known.error();
    const exec::Principal* principal = exec::principal_of(context);
    return principal != nullptr ? principal->name : "anonymous";
  };
}

class AuthenticatorTest : public testing::Test {
 protected:
  AuthenticatorTest() {
    spdlog::set_level(spdlog::level::off);
    dir_.write("tokens.toml", kRow);
  }

  std::unique_ptr<Authenticator> make(bool client_certificates = false) const {
    auto made = Authenticator::make(dir_.path("tokens.toml"), client_certificates);
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }

  static inline const std::string kRow = token_row("robot", "secret", "read", R"("")");
  const tests::TempDir dir_;
};

TEST_F(AuthenticatorTest, TakesOneBearerToken) {
  const auto authenticator = make();
  const AskingServer server(authenticator->calls(), names_by(*authenticator));
  const auto channel = server.connect();
  EXPECT_EQ(ask(channel, {"Bearer secret"}), "robot");
  EXPECT_EQ(ask(channel, {"bearer secret"}), "robot");
  EXPECT_EQ(ask(channel, {"BEARER secret"}), "robot");
  EXPECT_EQ(authenticator->refused(), 0u);
  EXPECT_EQ(ask(channel, {}), "TOKEN_MISSING");
  EXPECT_EQ(ask(channel, {"secret"}), "TOKEN_MISSING");
  EXPECT_EQ(ask(channel, {"Basic secret"}), "TOKEN_MISSING");
  EXPECT_EQ(ask(channel, {"Bearer secret", "Bearer secret"}), "TOKEN_MISSING");
  EXPECT_EQ(ask(channel, {"Bearer secre"}), "TOKEN_UNKNOWN");
  EXPECT_EQ(ask(channel, {"Bearer secrets"}), "TOKEN_UNKNOWN");
  EXPECT_EQ(ask(channel, {"Bearer Secret"}), "TOKEN_UNKNOWN");
  EXPECT_EQ(authenticator->refused(), 7u);
}

TEST_F(AuthenticatorTest, AFileThatIsBadOrGoneKeepsTheOldTokens) {
  const auto authenticator = make();
  const AskingServer server(authenticator->calls(), names_by(*authenticator));
  const auto channel = server.connect();
  for (const std::string bad : {"", "[[token]]\nname = ", "[[token]]\nname = \"robot\"\n"}) {
    dir_.write("tokens.toml", bad);
    EXPECT_FALSE(authenticator->reload()) << bad;
    EXPECT_EQ(ask(channel, {"Bearer secret"}), "robot") << bad;
  }
  std::filesystem::remove(dir_.path("tokens.toml"));
  EXPECT_FALSE(authenticator->reload());
  EXPECT_EQ(ask(channel, {"Bearer secret"}), "robot");
  dir_.write("tokens.toml", token_row("robot", "new-secret", "read", R"("")"));
  EXPECT_TRUE(authenticator->reload());
  EXPECT_EQ(ask(channel, {"Bearer secret"}), "TOKEN_UNKNOWN");
  EXPECT_EQ(ask(channel, {"Bearer new-secret"}), "robot");
}

TEST_F(AuthenticatorTest, StartsOnlyWithAFileThatItUnderstands) {
  dir_.write("tokens.toml", kRow + "[[token]]\n");
  const auto bad = Authenticator::make(dir_.path("tokens.toml"), false);
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().code, Code::kInvalidArgument);
  EXPECT_NE(bad.error().message.find(dir_.path("tokens.toml")), std::string::npos);
  const auto none = Authenticator::make(dir_.path("none.toml"), false);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Code::kFailedPrecondition);
  dir_.write("large.toml", std::string(kMaxTokenFile + 1, '#'));
  EXPECT_FALSE(Authenticator::make(dir_.path("large.toml"), false));
}

TEST_F(AuthenticatorTest, WithoutTokensAndCertificatesEveryCallIsAnonymous) {
  const auto authenticator = Authenticator::make({}, false);
  ASSERT_TRUE(authenticator);
  const AskingServer server((*authenticator)->calls(), names_by(**authenticator));
  EXPECT_EQ(ask(server.connect(), {"Bearer secret"}), "anonymous");
}

/// A server to which only clients with a certificate of the authority can connect.
class AuthenticatorOfCertificates : public AuthenticatorTest {
 protected:
  std::shared_ptr<grpc::ServerCredentials> server_credentials() const {
    grpc::SslServerCredentialsOptions options(
        GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
    const tests::TestCertificate own = authority_.issue();
    options.pem_root_certs = authority_.certificate();
    options.pem_key_cert_pairs = {{own.key, own.certificate}};
    return grpc::SslServerCredentials(options);
  }
  std::shared_ptr<grpc::ChannelCredentials> client_credentials() const {
    const tests::TestCertificate own = authority_.issue({.name = "robot-7"});
    return grpc::SslCredentials({authority_.certificate(), own.key, own.certificate});
  }

  const tests::TestAuthority authority_;
};

TEST_F(AuthenticatorOfCertificates, ASubjectIsAPrincipalThatMayDoEverything) {
  const auto authenticator = Authenticator::make({}, true);
  ASSERT_TRUE(authenticator);
  const auto answer = [&](exec::CallContext& context) -> Result<std::string> {
    if (const Status known = (*authenticator)->authenticate(context); !known) return known.error();
    const exec::Principal* principal = exec::principal_of(context);
    return principal->may(exec::Role::kAdmin, "projects/p/scenes/s") ? principal->name : "";
  };
  const AskingServer server((*authenticator)->calls(), answer, "127.0.0.1:0", server_credentials());
  EXPECT_EQ(ask(server.connect(client_credentials())), "CN=robot-7");
}

TEST_F(AuthenticatorOfCertificates, ATokenIsNeededBesideTheCertificate) {
  const auto authenticator = make(true);
  const AskingServer server(authenticator->calls(), names_by(*authenticator), "127.0.0.1:0",
                            server_credentials());
  const auto channel = server.connect(client_credentials());
  EXPECT_EQ(ask(channel), "TOKEN_MISSING");
  EXPECT_EQ(ask(channel, {"Bearer secret"}), "robot");
}

}  // namespace
}  // namespace sightline::server::security
