// A pointer to a split rule, for code that passes it on and never calls it.
#pragma once

#include <memory>

namespace sightline::accel::split {

class SplitSearch;  // split_search.h

/// A rule that trees share with tasks which may outlive them. Never null.
using SplitRule = std::shared_ptr<const SplitSearch>;

/// The product's rule, scan_fast() (scan_split.h), made once. Threads: any.
const SplitRule& default_rule();

}  // namespace sightline::accel::split
