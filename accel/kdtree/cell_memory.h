// Memory of deferred cells. One thread allocates it and another frees it, all the time; the C
// library's allocator would make threads wait for each other.
#pragma once

#include <cstddef>

namespace sightline::accel::kdtree {

/// As std::realloc and std::free, with oneTBB's allocator. Builds with sanitizers use the C
/// library's, which sanitizers check.
void* reallocate_cell_memory(void* old, std::size_t bytes);
void free_cell_memory(void* memory);

}  // namespace sightline::accel::kdtree
