// libFuzzer target: the WebSocket of the live page, its messages, and the calls that they make.
// Built and run by tests/fuzz/run.
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include "tests/fuzz/page/check_page.h"
#include "tests/support/random.h"

using namespace sightline::tests;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

/// Without protobuf's line for every string that is not UTF-8.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  google::protobuf::SetLogHandler(nullptr);
  return 0;
}

/// Mostly repeats, drops and changes steps, some of them those of the examples; now and then bytes
/// as libFuzzer does.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  constexpr std::size_t kGrowth = 64;
  Random random(seed);
  auto steps = decode_page(std::span(data, size));
  if (steps.empty() || random.below(8) == 0) return LLVMFuzzerMutate(data, size, max_size);
  const auto any = [&](auto& of) -> auto& { return of[random.below(of.size())]; };
  auto examples = example_pages();
  PageStep& changed = any(steps);
  switch (random.below(4)) {
    case 0:
      steps.insert(steps.begin() + static_cast<long>(random.below(steps.size() + 1)),
                   any(any(examples)));
      break;
    case 1:
      steps.erase(steps.begin() + static_cast<long>(random.below(steps.size())));
      break;
    case 2:
      changed.kind = static_cast<PageStep::Kind>(random.below(PageStep::kKinds));
      break;
    default: {
      std::vector<std::uint8_t> bytes(changed.bytes.begin(), changed.bytes.end());
      const std::size_t before = bytes.size();
      bytes.resize(before + kGrowth);
      bytes.resize(LLVMFuzzerMutate(bytes.data(), before, bytes.size()));
      changed.bytes.assign(bytes.begin(), bytes.end());
    }
  }
  const auto encoded = encode_page(steps);
  if (encoded.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::copy(encoded.begin(), encoded.end(), data);
  return encoded.size();
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto wrong = check_page(decode_page(std::span(data, size)));
  if (!wrong) return 0;
  std::fprintf(stderr, "page: %s\n", wrong->c_str());
  std::abort();
}
