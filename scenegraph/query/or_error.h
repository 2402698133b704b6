// What stops the work of a batch, as an error.
#pragma once

#include <new>

#include "proto/result.h"
#include "scenegraph/model/mesh_source.h"

namespace sightline::scenegraph::query {

/// Returns what work() returns; kResourceExhausted if it throws std::bad_alloc, and the error of
/// model::MeshUnreadable. What was built until then remains, and the same work may succeed later.
template <class Work>
auto or_error(const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{Code::kResourceExhausted, "no memory is left for the trees that the rays need",
                 "OUT_OF_MEMORY"};
  } catch (const model::MeshUnreadable& thrown) {
    return thrown.error();
  }
}

}  // namespace sightline::scenegraph::query
