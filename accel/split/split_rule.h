// A split rule as what holds it sees it: passed on, not asked.
#pragma once

#include <memory>

namespace sightline::accel::split {

class SplitSearch;  // split_search.h

/// Shared by trees and by tasks that may outlive them. Never null.
using SplitRule = std::shared_ptr<const SplitSearch>;

/// The product's rule, scan_fast() (scan_split.h), made once. Threads: any.
const SplitRule& default_rule();

}  // namespace sightline::accel::split
