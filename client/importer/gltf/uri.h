// The uri of a buffer. Internal to the importer.
#pragma once

#include <string>
#include <string_view>

namespace sightline::client::importer::gltf {

/// Whether the URI holds the bytes itself.
bool is_data_uri(std::string_view uri);

/// The bytes in a data URI. Refuses one that is damaged; `where` is whose it is.
std::string decode_data_uri(std::string_view uri, std::string_view where);

/// "two%20words" as "two words". A percent sign without two hexadecimal digits stays.
std::string percent_decoded(std::string_view text);

}  // namespace sightline::client::importer::gltf
