// Pictures as columns of hits: one stream of casts, all of one revision, whose rays the server makes.

const kRaysPerRequest = 16384;

// What each mode of shade.js needs, and selection.js.
const kFields = {
  lit: ['HIT_FIELD_NORMAL'],
  normal: ['HIT_FIELD_NORMAL'],
  depth: ['HIT_FIELD_T'],
  node: ['HIT_FIELD_NODE', 'HIT_FIELD_NORMAL'],
  heat: ['HIT_FIELD_WORK'],
  outline: ['HIT_FIELD_HIT'],
};
const kColumns = {
  1: {name: 't', type: Float64Array, width: 1},
  2: {name: 'node', type: BigUint64Array, width: 1},
  5: {name: 'normal', type: Float32Array, width: 3},
  6: {name: 'hit', type: Uint8Array, width: 1},
  7: {name: 'work', type: Uint32Array, width: 1},
};

// Copies the bytes of a column, whatever their alignment.
function put(columns, {field, data}, first, rays) {
  const {name, type, width} = kColumns[field];
  columns[name] ??= new type(rays * width);
  new Uint8Array(columns[name].buffer).set(data, first * width * type.BYTES_PER_ELEMENT);
}

// samples: of a pixel, see Camera.pinhole(). Resolves to {columns, width, height, perPixel}; the columns have a
// row for each ray. `build`: a BuildMode. `root`: the node that alone is met, with those below it; 0: all are.
export function castFrame(connection, scene, camera, {width, height, samples = [], mode, build, root = 0}) {
  const perPixel = Math.max(1, samples.length / 2);
  const rays = width * height * perPixel;
  const requests = [];
  for (let first = 0; first < rays; first += kRaysPerRequest) {
    requests.push({
      scene, build, root, kind: mode === 'outline' ? 'QUERY_KIND_ANY' : 'QUERY_KIND_CLOSEST', fields: kFields[mode],
      generator: {
        pinhole: camera.pinhole(width, height, samples), first, count: Math.min(kRaysPerRequest, rays - first),
      },
    });
  }
  const columns = {};
  const call = connection.castAll(requests, (chunk, answer) => {
    for (const column of answer.columns) put(columns, column, chunk * kRaysPerRequest, rays);
  });
  return {done: call.done.then(() => ({columns, width, height, perPixel})), cancel: call.cancel};
}
