// From columns of hits to colours.
import {dot, scale} from './camera.js';

const kSky = [16, 20, 24];
const kUnbuilt = 0x80000000;  // of WORK: the ray met a cell that is not built

const clamp = x => x < 0 ? 0 : x > 1 ? 1 : x;

// Colours between stops that are evenly spaced, s from 0 to 1.
function ramp(stops, s) {
  const at = clamp(s) * (stops.length - 1);
  const first = Math.min(Math.floor(at), stops.length - 2);
  const part = at - first;
  return stops[first].map((c, i) => c + (stops[first + 1][i] - c) * part);
}

const kHeat = [[6, 6, 18], [66, 22, 110], [160, 38, 106], [226, 84, 62], [250, 168, 60], [252, 246, 190]];
const kDepth = [[253, 240, 196], [150, 205, 160], [60, 160, 175], [45, 95, 165], [40, 35, 90]];

// A table of 256 colours.
const tabled = stops => Array.from({length: 256}, (_, i) => ramp(stops, i / 255));
const kHeatTable = tabled(kHeat);
const kDepthTable = tabled(kDepth);

// The golden ratio gives consecutive ids distant hues.
function hueOf(id) {
  const turns = Number(id % 1000003n) * 0.6180339887498949;
  const h = 6 * (turns - Math.floor(turns));
  const f = k => { const x = (k + h) % 6; return 1 - 0.55 * clamp(Math.min(x, 4 - x)); };
  return [f(5) * 235, f(3) * 225, f(1) * 235];
}

// The value that is larger than `part` of some of the values that are positive.
function quantile(values, part) {
  const some = [];
  const step = Math.max(1, Math.floor(values.length / 4096));
  for (let i = 0; i < values.length; i += step) if (values[i] > 0 && Number.isFinite(values[i])) some.push(values[i]);
  some.sort((a, b) => a - b);
  return some.length ? some[Math.floor(part * (some.length - 1))] : 1;
}

// A function from a ray's index to a colour, or to null for a miss.
function colourer(mode, {t, normal, node, work}, camera) {
  const {forward, right, up} = camera.frame();
  const facing = i => {
    const n = [normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]];
    return dot(n, forward) > 0 ? scale(n, -1) : n;
  };
  const missed = i => normal[3 * i] === 0 && normal[3 * i + 1] === 0 && normal[3 * i + 2] === 0;
  if (mode === 'normal') {
    return i => missed(i) ? null : [normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]].map(x => 127.5 + 127.5 * x);
  }
  if (mode === 'lit' || mode === 'node') {
    const sun = [-0.45, 0.75, -0.5];
    const toSun = right.map((r, a) => sun[0] * r + sun[1] * up[a] + sun[2] * forward[a]);
    return i => {
      if (missed(i)) return null;
      const light = 0.28 + 0.72 * Math.max(0, dot(facing(i), toSun));
      const colour = mode === 'lit' ? [226, 221, 212] : hueOf(node[i]);
      return [colour[0] * light, colour[1] * light, colour[2] * light];
    };
  }
  if (mode === 'depth') {
    const near = quantile(t, 0.01), far = quantile(t, 0.99);
    const span = Math.max(far - near, 1e-9 * Math.abs(far));
    return i => Number.isFinite(t[i]) ? kDepthTable[Math.round(255 * clamp((t[i] - near) / span))] : null;
  }
  const most = quantile(Float64Array.from(work, w => w & ~kUnbuilt), 0.995);
  return i => kHeatTable[Math.round(255 * clamp((work[i] & ~kUnbuilt) / most))];
}

// The picture as an ImageData.
export function shade(frame, mode, camera) {
  const {columns, width, height, perPixel} = frame;
  const image = new ImageData(width, height);
  const colour = colourer(mode, columns, camera);
  for (let pixel = 0, ray = 0; pixel < width * height; ++pixel) {
    let red = 0, green = 0, blue = 0;
    for (let sample = 0; sample < perPixel; ++sample, ++ray) {
      const [r, g, b] = colour(ray) ?? kSky;
      red += r; green += g; blue += b;
    }
    image.data[4 * pixel] = red / perPixel;
    image.data[4 * pixel + 1] = green / perPixel;
    image.data[4 * pixel + 2] = blue / perPixel;
    image.data[4 * pixel + 3] = 255;
  }
  return image;
}
