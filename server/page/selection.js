// The selected node over the picture: where rays meet it or what is below it, others before it or not; and the point that
// a ray has hit.
import {castFrame} from './frames.js';

const kInside = [40, 220, 130, 70], kEdge = [40, 220, 130, 255];
const kMarker = 6;  // pixels from the middle of the marker to its end

export class Selection {
  constructor(canvas) {
    this.canvas = canvas;
    this.clear();
  }

  clear() {
    this.node = 0;
    this.point = undefined;
    this.drawn = undefined;
    this.erase();
  }

  erase() { this.canvas.getContext('2d').clearRect(0, 0, this.canvas.width, this.canvas.height); }

  // Asks where the node is in a picture whose pixels are `coarse` times as large. Resolves to the number of its pixels;
  // undefined: it is out of date.
  async draw(connection, scene, camera, coarse) {
    const {canvas, node, point} = this;
    let image, count = 0;
    if (node) {
      const width = Math.ceil(canvas.width / coarse), height = Math.ceil(canvas.height / coarse);
      this.frame = castFrame(connection, scene, camera, {width, height, mode: 'outline', root: node});
      const {columns: {hit}} = await this.frame.done;
      if (this.node !== node || this.point !== point) return undefined;
      count = hit.reduce((sum, one) => sum + (one === 1), 0);
      image = await createImageBitmap(outline(hit, width, height));
    }
    this.erase();
    const context = canvas.getContext('2d');
    context.imageSmoothingEnabled = false;
    if (image) context.drawImage(image, 0, 0, canvas.width, canvas.height);
    if (point) mark(context, camera.projection(canvas.width, canvas.height)(point));
    return count * coarse * coarse;
  }
}

// A pixel of the node beside one that is not is its edge.
function outline(hit, width, height) {
  const image = new ImageData(width, height);
  const misses = (x, y) => x >= 0 && y >= 0 && x < width && y < height && hit[y * width + x] !== 1;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      if (misses(x, y)) continue;
      const isEdge = misses(x - 1, y) || misses(x + 1, y) || misses(x, y - 1) || misses(x, y + 1);
      image.data.set(isEdge ? kEdge : kInside, 4 * (y * width + x));
    }
  }
  return image;
}

function mark(context, [x, y, depth]) {
  if (depth <= 0) return;
  for (const [style, width] of [['#101418', 4], ['#ffffff', 2]]) {
    context.strokeStyle = style;
    context.lineWidth = width;
    context.beginPath();
    context.moveTo(x - kMarker, y);
    context.lineTo(x + kMarker, y);
    context.moveTo(x, y - kMarker);
    context.lineTo(x, y + kMarker);
    context.stroke();
  }
}
