// Makes a scene of hills, casts rays at it, moves it, and reads the reason of an error.
//
//   node first_query.mjs
//
// Variables: SIGHTLINE_PROTO, the folder of the .proto files; SIGHTLINE_ENDPOINT, HOST:PORT or unix:PATH;
// SIGHTLINE_TOKEN; SIGHTLINE_TLS_CA, a PEM file.
import { createHash, randomUUID } from "node:crypto";
import { readFileSync } from "node:fs";
import { columnsOf, raysOf } from "./columns.mjs";
import { Connection } from "./connection.mjs";
import { digestOf, meshBlob } from "./mesh.mjs";

const SCENE = "projects/default/scenes/hills-node";
const SIDE = 257; // vertices along each side of the hills, one unit apart
const CHUNK = 1 << 20; // bytes of a mesh in one message
const BATCH = 8192; // rays in one message
const IN_FLIGHT = 4; // messages on their way

const { env } = process;
const server = new Connection({
  endpoint: env.SIGHTLINE_ENDPOINT || "127.0.0.1:50151",
  protos: env.SIGHTLINE_PROTO || "/usr/share/sightline/proto",
  token: env.SIGHTLINE_TOKEN || "",
  ca: env.SIGHTLINE_TLS_CA ? readFileSync(env.SIGHTLINE_TLS_CA) : null,
});

function hills() {
  const positions = [], faces = [];
  for (let y = 0; y < SIDE; ++y) {
    for (let x = 0; x < SIDE; ++x) {
      positions.push(x, y, ((x * x + 3 * y * y + x * y) % 64) / 8);
      if (x + 1 === SIDE || y + 1 === SIDE) continue;
      const corner = y * SIDE + x;
      faces.push(corner, corner + 1, corner + SIDE, corner + 1, corner + SIDE + 1, corner + SIDE);
    }
  }
  return meshBlob(positions, faces);
}

// A mesh that the server has is not sent again.
async function upload(blob) {
  const digest = digestOf(blob);
  const { digests } = await server.call(server.blobs, "findMissingBlobs", { digests: [digest] });
  if (digests.length === 0) return digest;
  function* chunks() {
    for (let offset = 0; offset < blob.length; offset += CHUNK) {
      const data = blob.subarray(offset, offset + CHUNK);
      yield { digest, offset, data, finish: offset + data.length === blob.length };
    }
  }
  await server.send(server.blobs, "uploadBlob", chunks());
  return digest;
}

async function cast(origins, directions, consistency) {
  const rays = raysOf(Float64Array.from(origins.flat()), Float64Array.from(directions.flat()));
  const answer = await server.call(server.rays, "castRays", { scene: SCENE, rays, consistency });
  const { HIT_FIELD_T: t, HIT_FIELD_NODE: node, HIT_FIELD_PRIMITIVE: primitive } = columnsOf(answer);
  console.log(`revision ${answer.served.revision}`);
  t.forEach((distance, i) => console.log(`  t ${distance} node ${node[i]} primitive ${primitive[i]}`));
}

// Ray i of many: slanting rays over the hills and beyond.
function part(first, count) {
  const origins = new Float64Array(3 * count), directions = new Float64Array(3 * count);
  for (let i = 0; i < count; ++i) {
    origins.set([((first + i) % 500) * 0.53, Math.floor((first + i) / 500) * 1.31, 20], 3 * i);
    directions.set([0.25, -0.125, -1], 3 * i);
  }
  return raysOf(origins, directions);
}

// Casts `total` rays over one call, with a few messages in flight. The first says what is asked; of later ones only the
// rays count.
async function castMany(total) {
  const call = server.rays.streamCastRays(server.metadata(SCENE));
  let sent = 0;
  const sendNext = () => {
    if (sent >= total) return call.end();
    const rays = part(sent, Math.min(BATCH, total - sent));
    call.write({ chunk: sent / BATCH, request: { scene: SCENE, rays } });
    sent += BATCH;
    return undefined;
  };
  for (let i = 0; i < IN_FLIGHT; ++i) sendNext();
  const parts = { HIT_FIELD_T: [], HIT_FIELD_NODE: [], HIT_FIELD_PRIMITIVE: [] };
  for await (const { response } of call) { // throws if the call fails
    sendNext();
    for (const [field, column] of Object.entries(columnsOf(response))) parts[field].push(column);
  }
  const hits = parts.HIT_FIELD_T.reduce((sum, t) => sum + t.filter(Number.isFinite).length, 0);
  const hash = createHash("sha256");
  for (const column of Object.values(parts).flat()) hash.update(column);
  console.log(`${total} rays, ${hits} hits, columns ${hash.digest("hex")}`);
}

// Lifts a node. A call that is repeated with the same request id changes nothing.
async function lift(node, height) {
  const matrices = Buffer.from(Float64Array.of(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, height).buffer);
  const request = { scene: SCENE, requestId: randomUUID(), updates: [{ setTransforms: { nodes: [node], matrices } }] };
  const first = await server.call(server.scenes, "applyUpdates", request);
  const again = await server.call(server.scenes, "applyUpdates", request);
  const outcome = again.replayed ? "replayed" : "moved twice";
  console.log(`moved at revision ${first.revision.revision}, and again: ${outcome}`);
  return first.revision.token;
}

const digest = await upload(hills());
console.log(`mesh ${digest}`);
const nodes = [{ node: -1, name: "hills", meshDigest: digest }];
const put = [{ scene: { name: SCENE }, replace: true }, { nodes }, { finish: true }];
const { scene } = await server.send(server.scenes, "putScene", put, SCENE);
console.log(`scene of ${scene.nodes} node, ${scene.trianglesUnique} triangles`);

const origins = [[10.3, 20.6, 30], [100.25, 200.5, 30], [-5, -5, 30], [0, 0, 30]];
const directions = [[0, 0, -1], [0.1, 0.2, -1], [0, 0, -1], [0, 0, 0]]; // the third misses, the last is none
await cast(origins, directions);
await castMany(100_000);
const token = await lift("1", 2.5);
await cast(origins, directions, { atLeast: token });

try {
  await server.call(server.rays, "castRays", { scene: `${SCENE}-2`, rays: part(0, 1) });
} catch (error) {
  if (server.detailsOf(error).reason !== "SCENE_NOT_FOUND") throw error;
  console.log(`as expected: ${error.details}`);
}
server.close();
