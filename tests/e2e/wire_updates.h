// Updates of the scene graph as messages.
#pragma once

#include <span>

#include "scenegraph/model/update.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::tests {

/// Meshes go by their digests.
v1::Update to_message(const scenegraph::Update& update);

template <class Request>
void add_updates(Request& request, std::span<const scenegraph::Update> updates) {
  for (const scenegraph::Update& update : updates) *request.add_updates() = to_message(update);
}

}  // namespace sightline::tests
