// The boxes of deferred cells over the picture. Those that rays have built fade away.

const kCells = 1000;
const kFade = 700;  // milliseconds
const kEdges = [[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]];

export class Cells {
  constructor(canvas) {
    this.canvas = canvas;
    this.boxes = new Map();  // text of the box: {corners, gone: when it was built}
    this.total = 0;
    this.shown = true;
  }

  clear() { this.boxes.clear(); this.total = 0; this.#erase(); }

  // Asks the server what is not built yet.
  async update(connection, scene) {
    const answer = await connection.deferredCells(scene, kCells);
    const bytes = answer.boxes ?? new Uint8Array();
    const numbers = new Float32Array(bytes.slice().buffer);
    const seen = new Set();
    for (let i = 0; i < numbers.length; i += 6) {
      const box = numbers.subarray(i, i + 6);
      const key = box.join();
      seen.add(key);
      if (!this.boxes.has(key) || this.boxes.get(key).gone) this.boxes.set(key, {corners: corners(box)});
    }
    const now = performance.now();
    for (const [key, box] of this.boxes) if (!seen.has(key)) box.gone ??= now;
    this.total = answer.total ?? 0;
  }

  // Returns whether it changes by itself.
  draw(camera) {
    this.#erase();
    if (!this.shown) return false;
    const {width, height} = this.canvas;
    const project = camera.projection(width, height);
    const here = new Path2D(), fading = [];
    const now = performance.now();
    for (const [key, box] of this.boxes) {
      const left = box.gone ? 1 - (now - box.gone) / kFade : 1;
      if (left <= 0) { this.boxes.delete(key); continue; }
      const path = box.gone ? new Path2D() : here;
      trace(path, box.corners.map(project));
      if (box.gone) fading.push([path, left]);
    }
    const context = this.canvas.getContext('2d');
    context.lineWidth = 1;
    context.strokeStyle = `rgb(120 190 255 / ${this.boxes.size > 100 ? 0.25 : 0.5})`;
    context.stroke(here);
    for (const [path, left] of fading) {
      context.strokeStyle = `rgb(255 190 90 / ${left})`;
      context.stroke(path);
    }
    return fading.length > 0;
  }

  #erase() { this.canvas.getContext('2d').clearRect(0, 0, this.canvas.width, this.canvas.height); }
}

const corners = box => Array.from({length: 8}, (_, i) => [box[i & 1 ? 3 : 0], box[i & 2 ? 4 : 1], box[i & 4 ? 5 : 2]]);

function trace(path, points) {
  for (const [a, b] of kEdges) {
    if (points[a][2] <= 0 || points[b][2] <= 0) continue;
    path.moveTo(points[a][0], points[a][1]);
    path.lineTo(points[b][0], points[b][1]);
  }
}
