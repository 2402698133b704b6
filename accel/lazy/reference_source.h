// Where a tree's references come from.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "accel/kdtree/reference.h"

namespace sightline::accel::lazy {

/// Threads: all functions, any, several at once; they are pure. They count what they do.
struct ReferenceSource {
  /// The coarsest references, from which the root is expanded, have indices from 0 on. An index may
  /// have no reference.
  struct Coarsest {
    std::size_t places = 0;
    bool openable = false;  ///< Some may be.
  };
  /// Called before `list`; always the same.
  std::function<Coarsest(kdtree::BuildCounters&)> coarsest;
  /// Writes the references with indices from `begin` to `end`, and returns their number.
  std::function<std::size_t(std::size_t begin, std::size_t end, kdtree::BoxRef* out,
                            kdtree::BuildCounters&)>
      list;
  /// Appends the references that an openable one stands for; they may be openable too. Their boxes
  /// lie within its own. A reference always opens into the same ones.
  std::function<void(const kdtree::BoxRef&, std::vector<kdtree::BoxRef>&, kdtree::BuildCounters&)>
      open{};
  /// Keeps alive what the functions read. If null, only threads that hold it by other means call
  /// them: idle threads are not called to help.
  std::shared_ptr<const void> alive{};
};

/// A source of references that are made already; if some are openable, `open` is to be set.
inline ReferenceSource source_of(std::span<const kdtree::BoxRef> refs) {
  const bool openable = std::any_of(refs.begin(), refs.end(),
                                    [](const kdtree::BoxRef& ref) { return ref.openable(); });
  return {.coarsest =
              [places = refs.size(), openable](kdtree::BuildCounters&) {
                return ReferenceSource::Coarsest{places, openable};
              },
          .list =
              [refs](std::size_t begin, std::size_t end, kdtree::BoxRef* out,
                     kdtree::BuildCounters& counters) {
                counters.touches_prepare += end - begin;
                std::copy(refs.begin() + static_cast<std::ptrdiff_t>(begin),
                          refs.begin() + static_cast<std::ptrdiff_t>(end), out);
                return end - begin;
              }};
}

}  // namespace sightline::accel::lazy
