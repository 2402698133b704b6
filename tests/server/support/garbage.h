// Peers that do not speak HTTP/2.
#pragma once

namespace sightline::tests {

/// Opens three connections: random bytes, an HTTP/1.1 request, random bytes after HTTP/2's preface.
/// Returns when the server has closed all of them.
void send_garbage(int port);

}  // namespace sightline::tests
