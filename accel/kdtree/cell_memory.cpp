// oneTBB's allocator, or the C library's.
#include "accel/kdtree/cell_memory.h"

#ifdef SIGHTLINE_SCALABLE_MALLOC
#include <tbb/scalable_allocator.h>
#else
#include <cstdlib>
#endif

namespace sightline::accel::kdtree {

#ifdef SIGHTLINE_SCALABLE_MALLOC
void* reallocate_cell_memory(void* old, std::size_t bytes) { return scalable_realloc(old, bytes); }
void free_cell_memory(void* memory) { scalable_free(memory); }
#else
void* reallocate_cell_memory(void* old, std::size_t bytes) { return std::realloc(old, bytes); }
void free_cell_memory(void* memory) { std::free(memory); }
#endif

}  // namespace sightline::accel::kdtree
