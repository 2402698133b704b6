// A fuzzer's input as what a page sends through its WebSocket.
#include "tests/fuzz/page/page_session.h"

#include <algorithm>
#include <cstddef>

#include "sightline/page/v1/tunnel.pb.h"
#include "sightline/v1/scene.pb.h"
#include "sightline/v1/server.pb.h"
#include "tests/fuzz/bytes.h"

namespace sightline::tests {
namespace {

constexpr std::size_t kMaxSteps = 64;

page::v1::TunnelRequest request(std::uint32_t call, const std::string& method,
                                const std::string& message, bool last = true) {
  page::v1::TunnelRequest made;
  made.set_call(call);
  if (!method.empty()) made.set_method("/sightline.v1." + method);
  made.set_message(message);
  made.set_last(last);
  return made;
}

PageStep step(const page::v1::TunnelRequest& request) {
  return {PageStep::kMessage, request.SerializeAsString()};
}

PageStep info(std::uint32_t call, const std::string& authorization) {
  auto made = request(call, "ServerService/GetServerInfo", "");
  made.set_authorization(authorization);
  return step(made);
}

PageStep cancel(std::uint32_t call) {
  page::v1::TunnelRequest made;
  made.set_call(call);
  made.set_cancel(true);
  return step(made);
}

}  // namespace

std::vector<PageStep> decode_page(std::span<const std::uint8_t> bytes) {
  Bytes in(bytes);
  std::vector<PageStep> steps;
  while (!in.empty() && steps.size() < kMaxSteps) {
    PageStep step{static_cast<PageStep::Kind>(in.take<std::uint8_t>() % PageStep::kKinds), {}};
    const std::size_t length = in.take<std::uint16_t>();
    const auto content = in.rest().first(std::min(length, in.rest().size()));
    step.bytes.assign(content.begin(), content.end());
    in = Bytes(in.rest().subspan(content.size()));
    steps.push_back(std::move(step));
  }
  return steps;
}

std::vector<std::uint8_t> encode_page(const std::vector<PageStep>& steps) {
  std::vector<std::uint8_t> out;
  for (const PageStep& step : steps) {
    const std::size_t length = std::min<std::size_t>(step.bytes.size(), 0xffff);
    out.push_back(step.kind);
    out.push_back(static_cast<std::uint8_t>(length));
    out.push_back(static_cast<std::uint8_t>(length >> 8));
    out.insert(out.end(), step.bytes.begin(), step.bytes.begin() + static_cast<long>(length));
  }
  return out;
}

std::vector<std::vector<PageStep>> example_pages() {
  v1::GetSceneRequest scene;
  scene.set_name("projects/default/scenes/none");
  const std::string name = scene.SerializeAsString();
  const PageStep read{PageStep::kRead, {}};
  const PageStep stream = step(request(2, "RayQueryService/StreamCastRays", "", false));
  const PageStep more = step(request(2, "", "x", false));
  return {
      {info(1, "Bearer token"), read, step(request(1, "SceneService/GetScene", name)), read},
      {stream, more, more, cancel(2), read, step(request(2, "", "", true))},
      {step(request(3, "SceneService/WatchScene", name, false)), more, cancel(3), cancel(9)},
      {info(1, "Bearer \n"), info(2, "Bearer \xc3\xa9"), info(3, std::string("Bearer \0", 8))},
      {step(request(1, "SceneService/\n", "")), step(request(1, "../x", "")), read},
      {stream, stream},
      {{PageStep::kFrame, "\x89ping"}, {PageStep::kFrame, "\x88"}, read},
      {{PageStep::kFrame, "\x02\x08\x01"}, {PageStep::kFrame, "\x80\x10\x01"}, read},
      {{PageStep::kRaw, std::string("\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff", 10)}},
      {{PageStep::kRaw,
        "\x82\x03"
        "abc"},
       read},
      {{PageStep::kFrame, "\x81text"}, {PageStep::kFrame, "\xf2rsv"}},
  };
}

}  // namespace sightline::tests
