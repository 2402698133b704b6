// Which tokens are sent where, and which files make a connection.
#include "client/calls/channel_credentials.h"

#include <gtest/gtest.h>

#include "tests/client/support/temp_dir.h"
#include "tests/support/certificates.h"

namespace sightline::client::calls {
namespace {

Code code_of(const Result<ChannelCredentials>& made) {
  return made ? Code::kUnknown : made.error().code;
}

TEST(ChannelCredentials, KeepATokenFromPlaintext) {
  ClientOptions options;
  options.token = "secret";
  for (const char* local : {"127.0.0.1:1", "127.1.2.3:1", "[::1]:1", "localhost:1", "unix:/s"})
    EXPECT_TRUE(ChannelCredentials::make(*Endpoint::parse(local), options)) << local;
  for (const char* remote : {"10.0.0.1:1", "example.org:1", "[fe80::1]:1", "127.0.0.1.example:1",
                             "localhost.example:1", "0.0.0.0:1"}) {
    const auto refused = ChannelCredentials::make(*Endpoint::parse(remote), options);
    EXPECT_EQ(code_of(refused), Code::kUnauthenticated) << remote;
    EXPECT_EQ(refused.error().message.find("secret"), std::string::npos);
  }
  const tests::TempDir dir;
  options.tls_ca = dir.write("ca.pem", tests::TestAuthority().certificate());
  EXPECT_TRUE(ChannelCredentials::make(*Endpoint::parse("example.org:1"), options))
      << "with TLS it may leave";
}

TEST(ChannelCredentials, ATokenIsVisibleAscii) {
  ClientOptions options;
  for (const char* bad : {"a b", "a\n", "a\r\nx: y", "\xc3\xa4"}) {
    options.token = bad;
    EXPECT_EQ(code_of(ChannelCredentials::make(*Endpoint::parse("localhost:1"), options)),
              Code::kInvalidArgument);
  }
}

TEST(ChannelCredentials, FilesMustBeThereAndComplete) {
  const tests::TempDir dir;
  const tests::TestAuthority authority;
  ClientOptions options;
  options.tls_ca = dir.path("none.pem");
  EXPECT_EQ(code_of(ChannelCredentials::make(*Endpoint::parse("h:1"), options)),
            Code::kInvalidArgument);
  options.tls_ca = dir.write("ca.pem", authority.certificate());
  options.tls_cert = dir.write("own.pem", authority.issue().certificate);
  EXPECT_EQ(code_of(ChannelCredentials::make(*Endpoint::parse("h:1"), options)),
            Code::kInvalidArgument)
      << "no key";
  options.tls_key = dir.write("own.key", authority.issue().key);
  EXPECT_TRUE(ChannelCredentials::make(*Endpoint::parse("h:1"), options));
  options.tls_ca.clear();
  EXPECT_EQ(code_of(ChannelCredentials::make(*Endpoint::parse("h:1"), options)),
            Code::kInvalidArgument)
      << "no TLS";
}

}  // namespace
}  // namespace sightline::client::calls
