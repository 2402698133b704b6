// Principals and connections from the peers that gRPC names.
#include "server/exec/caller.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/exec/call_context.h"
#include "tests/client/support/temp_dir.h"
#include "tests/server/support/asking_server.h"

namespace sightline::server::exec {
namespace {

TEST(Caller, IsAnAddressAndAConnection) {
  EXPECT_EQ(caller_of("ipv4:10.0.0.7:4711").principal, "ipv4:10.0.0.7");
  EXPECT_EQ(caller_of("ipv4:10.0.0.7:4711").connection, "ipv4:10.0.0.7:4711");
  EXPECT_EQ(caller_of("ipv6:%5B::1%5D:4711").principal, "ipv6:%5B::1%5D");
  EXPECT_EQ(caller_of("unix:/run/sightline").principal, "unix:/run/sightline");
  EXPECT_EQ(caller_of("").principal, "");
}

TEST(Caller, EachConnectionToAUnixSocketIsOne) {
  const tests::TempDir dir;
  CallContexts calls;
  const auto connection_of = [](CallContext& context) -> Result<std::string> {
    return caller_of(context).connection;
  };
  const tests::AskingServer server(calls, connection_of, "unix:" + dir.path("socket"));
  const auto one = server.connect(), other = server.connect();
  const std::string name = tests::ask(one);
  EXPECT_TRUE(name.starts_with("unix:")) << name;
  EXPECT_EQ(tests::ask(one), name);
  EXPECT_NE(tests::ask(other), name);
}

TEST(Caller, HasTheNameOfThePrincipal) {
  CallContexts calls;
  const auto principal_of_call = [](CallContext& context) -> Result<std::string> {
    const std::string before = caller_of(context).principal;
    context.set_principal(
        std::make_shared<const Principal>(Principal{.name = "robot", .grants = {}}));
    return before + " " + caller_of(context).principal;
  };
  const tests::AskingServer server(calls, principal_of_call);
  EXPECT_EQ(tests::ask(server.connect()), "ipv4:127.0.0.1 robot");
}

}  // namespace
}  // namespace sightline::server::exec
