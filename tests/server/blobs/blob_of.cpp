// Meshes in the form that clients upload.
#include "tests/server/blobs/blob_of.h"
namespace sightline::tests {
namespace {

template <class T>
void append(std::string& blob, const T* values, std::size_t count) {
  blob.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

}  // namespace

std::string blob_of(const TestMesh& mesh) {
  std::string blob = "SLM1";
  const std::uint32_t reserved = 0;
  const std::uint64_t counts[] = {mesh.vertices.size(), mesh.faces.size()};
  append(blob, &reserved, 1);
  append(blob, counts, 2);
  append(blob, mesh.vertices.data(), mesh.vertices.size());
  append(blob, mesh.faces.data(), mesh.faces.size());
  return blob;
}

server::blobs::BlobDigest digest_of(const std::string& bytes) {
  server::blobs::Sha256 sum;
  sum.update(bytes_of(bytes));
  return {sum.finish(), bytes.size()};
}

}  // namespace sightline::tests
