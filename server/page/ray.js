// One ray: its numbers as text, and what it hits.

const kLongestQuoted = 40;  // characters of a text that is no number
const kNumber = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;
const kInvalid = 2;  // of HIT_FIELD_HIT

const kFields = ['T', 'NODE', 'NAME', 'PRIMITIVE', 'BARYCENTRIC', 'NORMAL', 'POSITION', 'HIT', 'WORK'];

// float32 values as numbers with the fewest digits that tell them from others.
const short = numbers => [...numbers].map(value =>
  [6, 7, 8, 9].map(digits => Number(value.toPrecision(digits))).find(one => Math.fround(one) === value) ?? value);

export const asText = numbers => numbers.map(value => String(value + 0)).join(' ');

// Three numbers with spaces or commas between them. Throws an Error that names what is wrong.
export function readTriple(text, name) {
  const words = text.split(/[\s,;]+/).filter(word => word);
  const bad = words.find(word => !kNumber.test(word));
  if (bad !== undefined) throw new Error(`${name}: '${shorten(bad)}' is no number`);
  if (words.length !== 3) throw new Error(`${name}: 3 numbers are needed, x y z, not ${words.length}`);
  const numbers = words.map(Number);
  const large = numbers.findIndex(value => !Number.isFinite(value));
  if (large >= 0) throw new Error(`${name}: ${shorten(words[large])} is beyond 1.8e308, the largest number`);
  return numbers;
}

const shorten = word => word.length > kLongestQuoted ? `${word.slice(0, kLongestQuoted)}…` : word;

// Resolves to {t, node, name, primitive, barycentric, normal, position, work}, or to {} for a miss. Errors: those of the
// service, and that it takes the ray as invalid.
export async function castRay(connection, scene, origin, direction) {
  const answer = await connection.cast({
    scene, kind: 'QUERY_KIND_CLOSEST', fields: kFields.map(field => `HIT_FIELD_${field}`),
    rays: {float64: true, count: 1, origins: doubles(origin), directions: doubles(direction)},
  });
  const columns = new Map(answer.columns.map(({field, data}) => [field, data.slice().buffer]));
  const [t, node, primitive, barycentric, normal, hit, work, position, name] =
    [[1, Float64Array], [2, BigUint64Array], [3, Uint32Array], [4, Float32Array], [5, Float32Array], [6, Uint8Array],
      [7, Uint32Array], [11, Float64Array], [12, Uint32Array]].map(([field, type]) => new type(columns.get(field)));
  if (hit[0] === kInvalid) {
    throw new Error('the server takes this ray as invalid: its direction is zero or too small, or a number is too large');
  }
  if (node[0] === 0n) return {};
  return {
    t: t[0], node: Number(node[0]), name: answer.names[name[0]] ?? '', primitive: primitive[0],
    barycentric: short(barycentric), normal: short(normal), position: [...position], work: work[0] & 0x7fffffff,
  };
}

const doubles = numbers => new Uint8Array(Float64Array.from(numbers).buffer);
