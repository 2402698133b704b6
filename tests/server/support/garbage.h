// Peers that do not speak HTTP/2.
#pragma once

namespace sightline::tests {

/// Three connections: random bytes, an HTTP/1.1 request, random bytes behind HTTP/2's preface.
/// Returns when the server has hung up on all.
void send_garbage(int port);

}  // namespace sightline::tests
