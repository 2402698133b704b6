// No exception may leave a task or a reactor: what is thrown becomes an error of the call.
#pragma once

#include <exception>
#include <new>

#include "accel/result.h"

namespace sightline::server::exec {

/// The Status that work() returns, or kResourceExhausted for std::bad_alloc, or kInternal for
/// anything else.
template <class Work>
Status to_status(Work&& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{Code::kResourceExhausted, "the server has no memory left for this",
                 "OUT_OF_MEMORY"};
  } catch (const std::exception& thrown) {
    return Error{Code::kInternal, thrown.what(), "UNEXPECTED"};
  }
}

}  // namespace sightline::server::exec
