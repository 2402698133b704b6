// A camera that orbits a point.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = a => Math.sqrt(dot(a, a));

const kHalfHeight = Math.tan(20 * Math.PI / 180);  // of the picture plane at distance 1
const kSteepest = 1.5;  // radians above or below the horizon
const kMargin = 1.1;
const kUpAxisZ = 2;

export class Camera {
  // scene: a message Scene. The whole scene is seen.
  constructor(scene, aspect) {
    const b = scene.bounds.length === 6 ? scene.bounds : [-1, -1, -1, 1, 1, 1];
    this.at = [0, 1, 2].map(i => (b[i] + b[i + 3]) / 2);
    this.corners = Array.from({length: 8}, (_, i) => [b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]]);
    this.radius = length(sub(b.slice(3), b.slice(0, 3))) / 2 || 1;
    this.distance = this.radius;
    this.zUp = scene.up_axis === kUpAxisZ;
    this.aspect = aspect;
    this.home();
  }

  home() {
    this.azimuth = 0.9;
    this.elevation = 0.45;
    this.target = this.at;
    const {forward, right, up} = this.frame();
    this.distance = Math.max(...this.corners.map(corner => {
      const d = sub(corner, this.at);
      const apart = Math.max(Math.abs(dot(d, right)) / this.aspect, Math.abs(dot(d, up)));
      return kMargin * apart / kHalfHeight - dot(d, forward);
    }));
  }

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.max(-kSteepest, Math.min(kSteepest, this.elevation + elevation));
  }

  zoom(factor) { this.distance = Math.max(1e-4 * this.radius, Math.min(100 * this.radius, this.distance * factor)); }

  // x and y in picture heights.
  move(x, y) {
    const {right, up} = this.frame();
    const reach = 2 * kHalfHeight * this.distance;
    this.target = add(this.target, add(scale(right, -x * reach), scale(up, y * reach)));
  }

  frame() {
    const across = Math.cos(this.elevation);
    const side = [across * Math.cos(this.azimuth), across * Math.sin(this.azimuth)];
    const back = this.zUp ? [side[0], side[1], Math.sin(this.elevation)] : [side[1], Math.sin(this.elevation), side[0]];
    const upright = this.zUp ? [0, 0, 1] : [0, 1, 0];
    const forward = scale(back, -1);
    const sideways = cross(forward, upright);
    const right = scale(sideways, 1 / length(sideways));
    return {eye: add(this.target, scale(back, this.distance)), forward, right, up: cross(right, forward)};
  }

  // The message Pinhole of a picture. samples: (k, 2) within a pixel; empty: its centre.
  pinhole(width, height, samples = []) {
    const {eye, forward, right, up} = this.frame();
    const halfWidth = kHalfHeight * this.aspect;
    const corner = add(forward, sub(scale(up, kHalfHeight), scale(right, halfWidth)));
    return {eye, corner, across: scale(right, 2 * halfWidth), down: scale(up, -2 * kHalfHeight), width, height, samples};
  }

  // The ray through the middle of a pixel, as {origin, direction}; the direction has length 1.
  ray(x, y, width, height) {
    const {eye, corner, across, down} = this.pinhole(width, height);
    const through = add(corner, add(scale(across, (x + 0.5) / width), scale(down, (y + 0.5) / height)));
    return {origin: eye, direction: scale(through, 1 / length(through))};
  }

  // A function from a point to [x, y, depth] in a picture of that size, depth > 0 in front.
  projection(width, height) {
    const {eye, forward, right, up} = this.frame();
    const perUnit = height / (2 * kHalfHeight);
    return point => {
      const d = sub(point, eye);
      const depth = dot(d, forward);
      return [width / 2 + dot(d, right) / depth * perUnit, height / 2 - dot(d, up) / depth * perUnit, depth];
    };
  }
}
