// Updates of the scene graph as messages.
#pragma once

#include <span>

#include "scenegraph/model/update.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::tests {

/// Meshes are referenced by their digests.
v1::Update to_message(const scenegraph::model::Update& update);

template <class Request>
void add_updates(Request& request, std::span<const scenegraph::model::Update> updates) {
  for (const scenegraph::model::Update& update : updates)
    *request.add_updates() = to_message(update);
}

}  // namespace sightline::tests
