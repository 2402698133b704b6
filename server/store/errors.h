// The errors of a store. Each names the file and what to do about it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "proto/result.h"

namespace sightline::server::store {

/// A call of the system that failed with `number`, an errno. kResourceExhausted (DISK_FULL),
/// kFailedPrecondition (STORE_READ_ONLY) or kUnavailable (STORE_IO).
Error file_error(std::string_view action, const std::filesystem::path& file, int number);

/// kResourceExhausted (DISK_FULL).
Error disk_full(const std::filesystem::path& file);
/// kFailedPrecondition (STORE_READ_ONLY).
Error read_only(const std::filesystem::path& file);
/// kDataLoss (STORE_CORRUPT). `what`: which part of the file is damaged.
Error corrupt(const std::filesystem::path& file, std::string_view what);
/// Whether a transaction failed for a reason that lies in the engine, as in its disk, and not in
/// the work.
bool is_of_engine(const Error& error);

/// kResourceExhausted: `use` of what `limit` bounds, under the limit's name.
Error over_limit(std::string_view name, std::uint64_t use, std::uint64_t limit, std::string reason);

}  // namespace sightline::server::store
