// Takes numbers out of Draco's mesh.
#include "client/importer/gltf/draco.h"

#include <draco/compression/decode.h>

#include <algorithm>
#include <limits>
#include <memory>

namespace sightline::client::importer::gltf {
namespace {

constexpr std::uint64_t kMostWidth = 4;

std::unique_ptr<draco::Mesh> decoded(std::string_view bytes, const std::string& where) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
  if (!mesh.ok())
    refuse("{}: its Draco data are damaged ({})", where, mesh.status().error_msg_string());
  return std::move(mesh).value();
}

double greatest(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return std::numeric_limits<std::int8_t>::max();
    case draco::DT_UINT8:
      return std::numeric_limits<std::uint8_t>::max();
    case draco::DT_INT16:
      return std::numeric_limits<std::int16_t>::max();
    case draco::DT_UINT16:
      return std::numeric_limits<std::uint16_t>::max();
    case draco::DT_INT32:
      return std::numeric_limits<std::int32_t>::max();
    case draco::DT_UINT32:
      return std::numeric_limits<std::uint32_t>::max();
    default:
      return 1;
  }
}

// Integers are taken as they are: whether they are normalised is for the accessor to say.
void read_row(const draco::PointAttribute& attribute, draco::AttributeValueIndex row, double* out) {
  const auto width = static_cast<std::int8_t>(attribute.num_components());
  if (attribute.data_type() == draco::DT_FLOAT32 || attribute.data_type() == draco::DT_FLOAT64) {
    attribute.ConvertValue<double>(row, width, out);
    return;
  }
  std::int64_t integers[kMostWidth] = {};
  attribute.ConvertValue<std::int64_t>(row, width, integers);
  for (int k = 0; k < width; ++k) out[k] = static_cast<double>(integers[k]);
}

DracoAttribute read(const draco::Mesh& mesh, const DracoRequest& request,
                    const std::string& where) {
  const draco::PointAttribute* const attribute =
      request.id <= std::numeric_limits<std::uint32_t>::max()
          ? mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(request.id))
          : nullptr;
  if (attribute == nullptr || attribute->num_components() < 1 ||
      attribute->num_components() > static_cast<int>(kMostWidth)) {
    refuse("{}: its Draco data have no attribute {} for {}", where, request.id, request.name);
  }
  DracoAttribute out;
  out.width = static_cast<std::size_t>(attribute->num_components());
  out.values.resize(out.width * mesh.num_points());
  for (std::uint32_t p = 0; p < mesh.num_points(); ++p) {
    const draco::AttributeValueIndex row = attribute->mapped_index(draco::PointIndex(p));
    if (row.value() >= attribute->size())
      refuse("{}: vertex {} of its Draco data has no {}", where, p, request.name);
    read_row(*attribute, row, out.values.data() + p * out.width);
  }
  if (request.is_normalized) {
    const double one = greatest(attribute->data_type());
    for (double& x : out.values) x = std::max(x / one, -1.0);
  }
  return out;
}

}  // namespace

DracoMesh decode_draco(std::string_view bytes, const std::vector<DracoRequest>& requests,
                       const std::string& where) {
  const std::unique_ptr<draco::Mesh> mesh = decoded(bytes, where);
  DracoMesh out;
  out.corners.reserve(std::size_t{3} * mesh->num_faces());
  for (std::uint32_t f = 0; f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& point : mesh->face(draco::FaceIndex(f)))
      out.corners.push_back(point.value());
  }
  for (const DracoRequest& request : requests)
    out.attributes[request.name] = read(*mesh, request, where);
  return out;
}

}  // namespace sightline::client::importer::gltf
