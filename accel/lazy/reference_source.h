// The source of a tree's references.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "accel/kdtree/reference.h"

namespace sightline::accel::lazy {

/// Functions that make references. All are pure, and add their work to the counters. Threads: any,
/// several at once.
struct ReferenceSource {
  /// The coarsest references, which the root is expanded from, are in slots 0 to `slots` - 1. A
  /// slot may be empty.
  struct Coarsest {
    std::size_t slots = 0;
    bool openable = false;  ///< Some references may be openable.
  };
  /// Called before `list`; always returns the same.
  std::function<Coarsest(kdtree::BuildCounters&)> coarsest;
  /// Writes the references of slots `begin` to `end` - 1, and returns their number.
  std::function<std::size_t(std::size_t begin, std::size_t end, kdtree::Reference* out,
                            kdtree::BuildCounters&)>
      list;
  /// Appends the references that an openable one stands for; some of them may be openable. Their
  /// boxes lie within its box. Always the same for the same reference.
  std::function<void(const kdtree::Reference&, std::vector<kdtree::Reference>&,
                     kdtree::BuildCounters&)>
      open{};
  /// For a hierarchy of references, whose root rays can search without meeting most of them: the
  /// number of references that are known by now. Rays search the root, under every policy, until
  /// that has cost as much as growing the tree. Null: the root is a list.
  std::function<std::size_t()> known{};
  /// Writes the references with these ids, in their order; none is openable, and all have been
  /// listed before. Null: lists of the tree cannot be compact.
  std::function<void(std::span<const std::uint32_t> ids, kdtree::Reference* out,
                     kdtree::BuildCounters&)>
      again{};
  /// Keeps alive what the functions read. If null, idle threads are not called to help: only
  /// threads that keep it alive in another way call the functions.
  std::shared_ptr<const void> alive{};
};

/// A source of given references, which must outlive it. If some are openable, the caller sets
/// `open`.
inline ReferenceSource source_of(std::span<const kdtree::Reference> refs) {
  const bool openable = std::any_of(refs.begin(), refs.end(),
                                    [](const kdtree::Reference& ref) { return ref.openable(); });
  return {.coarsest =
              [slots = refs.size(), openable](kdtree::BuildCounters&) {
                return ReferenceSource::Coarsest{slots, openable};
              },
          .list =
              [refs](std::size_t begin, std::size_t end, kdtree::Reference* out,
                     kdtree::BuildCounters& counters) {
                counters.touches_prepare += end - begin;
                std::copy(refs.begin() + static_cast<std::ptrdiff_t>(begin),
                          refs.begin() + static_cast<std::ptrdiff_t>(end), out);
                return end - begin;
              }};
}

}  // namespace sightline::accel::lazy
