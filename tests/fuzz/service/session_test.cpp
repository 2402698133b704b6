// The server under sessions of calls: as they are meant, changed at random, and kept from fuzzing.
#include <gtest/gtest.h>

#include <vector>

#include "tests/fuzz/corpus.h"
#include "tests/fuzz/service/check_session.h"
#include "tests/fuzz/service/mutate.h"

namespace sightline::tests {
namespace {

TEST(FuzzSession, IsTheSameAfterItIsEncoded) {
  for (const Session& session : example_sessions()) {
    const auto bytes = encode_session(session);
    EXPECT_EQ(encode_session(decode_session(bytes)), bytes);
  }
}

TEST(FuzzSession, ExamplesUseEveryMethod) {
  for (const auto* method : methods()) {
    bool used = false;
    for (const Session& session : example_sessions()) {
      for (const FuzzCall& call : session) used = used || &method_of(call) == method;
    }
    EXPECT_TRUE(used) << method->full_name();
  }
}

TEST(FuzzSession, ExamplesHaveNoFindings) {
  for (const Session& session : example_sessions()) {
    EXPECT_EQ(check_session(session), std::nullopt);
    EXPECT_EQ(check_decoders(session), std::nullopt);
  }
}

TEST(FuzzSession, MutantsHaveNoFindings) {
  constexpr std::uint64_t kMutants = 100;
  for (std::uint64_t i = 0; i < kMutants; ++i) {
    Random random(1, i);
    Session session = example_sessions()[random.below(example_sessions().size())];
    for (std::uint64_t changes = 1 + random.below(12); changes > 0; --changes)
      mutate(session, random);
    EXPECT_EQ(check_decoders(session), std::nullopt) << i;
    EXPECT_EQ(check_session(session), std::nullopt) << i;
  }
}

TEST(ServiceCorpus, HasNoFindings) {
  const std::vector<KeptInput> inputs = kept_inputs("service");
  EXPECT_GT(inputs.size(), 20u);
  for (const KeptInput& input : inputs) {
    const Session session = decode_session(input.bytes);
    EXPECT_EQ(check_decoders(session), std::nullopt) << input.name;
    EXPECT_EQ(check_session(session), std::nullopt) << input.name;
  }
}

}  // namespace
}  // namespace sightline::tests
