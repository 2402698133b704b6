// Names that fit into a message, in UTF-8. Internal to the importer.
#pragma once

#include <string>
#include <string_view>

namespace sightline::client::importer {

bool is_utf8(std::string_view text);

/// Makes a name fit for a message: `name` if it is UTF-8, else `name` read as Latin-1, followed by
/// `suffix`. A name that is too long is cut between characters, so that the result has at most
/// kMaxNodeName bytes.
std::string node_name(std::string_view name, std::string_view suffix = {});

}  // namespace sightline::client::importer
