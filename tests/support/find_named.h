// Looking up an element of a table by its name.
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

namespace sightline::tests {

/// The element of that name, or null.
template <class Named>
const Named* find_named(const std::vector<Named>& table, std::string_view name) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const Named& one) { return one.name == name; });
  return found == table.end() ? nullptr : &*found;
}

}  // namespace sightline::tests
