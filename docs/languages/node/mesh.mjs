// A mesh as the server takes it: the bytes of an SLM1 blob, and the digest that names them.
import { createHash } from "node:crypto";

const HEADER = 24; // bytes

// `positions`: three numbers a vertex; `faces`: three indices of vertices a face.
export function meshBlob(positions, faces) {
  if (positions.length % 3 !== 0) throw new RangeError(`${positions.length} coordinates are not three a vertex`);
  if (faces.length % 3 !== 0) throw new RangeError(`${faces.length} indices are not three a face`);
  const bytes = Buffer.alloc(HEADER + 4 * (positions.length + faces.length));
  bytes.write("SLM1", 0, "latin1");
  bytes.writeUInt32LE(0, 4); // copy number
  bytes.writeBigUInt64LE(BigInt(positions.length / 3), 8);
  bytes.writeBigUInt64LE(BigInt(faces.length / 3), 16);
  let at = HEADER;
  for (const coordinate of positions) at = bytes.writeFloatLE(coordinate, at);
  for (const index of faces) at = bytes.writeUInt32LE(index, at);
  return bytes;
}

export function digestOf(bytes) {
  return `sha256:${createHash("sha256").update(bytes).digest("hex")}/${bytes.length}`;
}
