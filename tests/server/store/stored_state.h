// All that a store answers, to compare before and after damage.
#pragma once

#include <map>
#include <string>

#include "server/store/store.h"

namespace sightline::tests {

/// Fills an empty store with rows of every kind: two scenes with batches, answers, producers,
/// meshes and snapshots, and one that is removed.
void fill_store(server::store::Store& store);

/// What each call about what fill_store() has stored answers: a text, or an error.
std::map<std::string, Result<std::string>> state_of(server::store::Store& store);

}  // namespace sightline::tests
