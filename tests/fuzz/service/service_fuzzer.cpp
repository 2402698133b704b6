// libFuzzer targets: a whole server (service_fuzzer), or its decoders alone (decoder_fuzzer). Built
// and run by tests/fuzz/run.
#include <google/protobuf/stubs/logging.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>

#include "tests/fuzz/service/check_session.h"
#include "tests/fuzz/service/mutate.h"

using namespace sightline::tests;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

/// Without protobuf's line for every string that is not UTF-8.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  google::protobuf::SetLogHandler(nullptr);
  return 0;
}

/// Mostly changes fields of messages, and now and then bytes as libFuzzer does.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  Random random(seed);
  if (random.below(8) == 0) return LLVMFuzzerMutate(data, size, max_size);
  Session session = decode_session(std::span(data, size));
  for (std::uint64_t changes = 1 + random.below(4); changes > 0; --changes) mutate(session, random);
  const auto bytes = encode_session(session);
  if (bytes.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto wrong = SIGHTLINE_FUZZ_CHECK(decode_session(std::span(data, size)));
  if (!wrong) return 0;
  std::fprintf(stderr, "service: %s\n", wrong->c_str());
  std::abort();
}
