// Memory of cells that are not built: allocated by one thread and freed by another, all the time,
// which the C library's allocator makes threads wait for.
#pragma once

#include <cstddef>

namespace sightline::accel::kdtree {

/// As std::realloc and std::free. Of oneTBB's allocator, but for builds with sanitizers, which
/// watch over the C library's.
void* reallocate_cell_memory(void* old, std::size_t bytes);
void free_cell_memory(void* memory);

}  // namespace sightline::accel::kdtree
