// What the error of a write says.
#include "server/scenes/write_errors.h"

#include "server/exec/memory_account.h"

namespace sightline::server::scenes {

bool says_nothing_of_the_batch(const Error& error) {
  return error.code == Code::kInternal || error.code == Code::kCancelled ||
         error.code == Code::kUnavailable || error.reason == "OUT_OF_MEMORY" ||
         error.reason == exec::kMemoryBudget;
}

}  // namespace sightline::server::scenes
