// Columns of numbers: the bytes of rays from arrays, and typed arrays from the bytes of an answer.
const TYPES = {
  HIT_FIELD_T: Float64Array,
  HIT_FIELD_NODE: BigUint64Array,
  HIT_FIELD_PRIMITIVE: Uint32Array,
  HIT_FIELD_BARYCENTRIC: Float32Array,
  HIT_FIELD_NORMAL: Float32Array,
  HIT_FIELD_HIT: Uint8Array,
  HIT_FIELD_WORK: Uint32Array,
  HIT_FIELD_COUNT: Uint32Array,
  HIT_FIELD_OFFSET: Uint32Array,
  HIT_FIELD_HIT_BITS: Uint8Array,
  HIT_FIELD_POSITION: Float64Array,
  HIT_FIELD_NAME: Uint32Array,
};

if (new Uint8Array(Uint16Array.of(1).buffer)[0] !== 1) throw new Error("typed arrays are not little-endian here");

// `Rays` of the protocol from two Float64Arrays with three numbers a ray.
export function raysOf(origins, directions) {
  const bytes = (array) => Buffer.from(array.buffer, array.byteOffset, array.byteLength);
  return { float64: true, origins: bytes(origins), directions: bytes(directions), count: origins.length / 3 };
}

// The columns of an answer by their fields. They are copied, as a message's bytes begin anywhere, and typed arrays only
// at multiples of their elements' size.
export function columnsOf(response) {
  const columns = {};
  for (const { field, data } of response.columns) {
    const Type = TYPES[field];
    if (Type === undefined) throw new Error(`a column of the unknown field ${field}`);
    columns[field] = new Type(data.buffer.slice(data.byteOffset, data.byteOffset + data.length));
  }
  return columns;
}
