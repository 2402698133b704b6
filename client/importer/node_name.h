// Names of nodes, as scene files have them, made fit for a message.
#pragma once

#include <string>
#include <string_view>

namespace sightline::client::importer {

/// `name` if it is UTF-8, else read as Latin-1; then `suffix`. Cut between characters, in the name,
/// to stay within kMaxNodeName bytes.
std::string node_name(std::string_view name, std::string_view suffix = {});

}  // namespace sightline::client::importer
