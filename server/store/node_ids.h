// Lists of node ids as bytes.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/store/store.h"

namespace sightline::server::store {

/// The differences of neighbours as variable-length numbers: a byte an id where they ascend by one.
std::string encode_ids(const std::vector<NodeId>& ids);

/// The ids; nothing if the bytes are not such a list.
std::optional<std::vector<NodeId>> decode_ids(std::span<const std::byte> bytes);

}  // namespace sightline::server::store
