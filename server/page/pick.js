// What one ray of the picture hits.

const f64 = data => new DataView(data.buffer, data.byteOffset, data.byteLength);

// x, y: a pixel of a picture of that size. Resolves to {t, node, name, primitive, work}, or {} for a miss.
export async function pick(connection, scene, camera, x, y, width, height) {
  const answer = await connection.cast({
    scene, kind: 'QUERY_KIND_CLOSEST',
    fields: ['HIT_FIELD_T', 'HIT_FIELD_NODE', 'HIT_FIELD_PRIMITIVE', 'HIT_FIELD_WORK', 'HIT_FIELD_NAME'],
    generator: {pinhole: camera.pinhole(width, height), first: y * width + x, count: 1},
  });
  const column = Object.fromEntries(answer.columns.map(({field, data}) => [field, f64(data)]));
  const node = Number(column[2].getBigUint64(0, true));
  if (node === 0) return {};
  return {
    t: column[1].getFloat64(0, true),
    node,
    name: answer.names[column[12].getUint32(0, true)] ?? '',
    primitive: column[3].getUint32(0, true),
    work: column[7].getUint32(0, true) & 0x7fffffff,
  };
}
