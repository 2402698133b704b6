// One scene to orbit: coarse at once, sharp when the camera rests.
import {Camera} from './camera.js';
import {Cells} from './cells.js';
import {describe, number} from './curve.js';
import {castFrame} from './frames.js';
import {Selection} from './selection.js';
import {shade} from './shade.js';

const kFinest = [0.375, 0.125, 0.875, 0.375, 0.125, 0.625, 0.625, 0.875];  // samples of a pixel that rests
const kFirst = 16, kCoarsest = 8;  // pixels side by side that share a ray: of the first frame, and at most
const kSmooth = 45;  // milliseconds that a frame may take
const kRest = 120;  // milliseconds after which a camera rests
const kStatsEvery = 1000;
const kPress = 4;  // pixels that a pointer may move while it presses
const kWatchAgain = 1000;  // milliseconds after the end of a watch
const kNotFound = 5, kResourceExhausted = 8, kOutOfRange = 11, kUnavailable = 14;

export class Viewer {
  // elements: picture, boxes, outline, built; failed(error); pressed(ray, pixel); watched(): a watch of the scene has begun;
  // updated(updates); outlined(pixels).
  constructor(connection, elements) {
    this.connection = connection;
    this.elements = elements;
    this.cells = new Cells(elements.boxes);
    this.selection = new Selection(elements.outline);
    this.mode = 'lit';
    this.coarse = kCoarsest;
    this.context = elements.picture.getContext('2d');
    this.frames = 0;
    this.#listen();
    setInterval(() => this.#refresh(), kStatsEvery);
    document.addEventListener('visibilitychange', () => { if (this.wanted) this.changed(); });
  }

  // known: the message Scene, if it is at hand.
  async open(name, known) {
    this.close();
    this.name = name;
    this.opened = performance.now();
    const {picture} = this.elements;
    const scene = known ?? (await this.connection.scene(name)).scene;
    if (this.name !== name) return;
    this.camera = new Camera(scene, picture.width / picture.height);
    this.coarse = kFirst;
    this.changed();
    this.#follow(name);
  }

  // Begins another watch where one ends by what may pass.
  async #follow(name) {
    while (this.name === name) {
      let begun = false;
      const watch = this.watch = this.connection.watch(name, answer => {
        if (!begun) this.elements.watched();
        begun = true;
        this.elements.updated(answer.updates);
        if (answer.progress || answer.more) return;
        this.revision = answer.revision.revision;
        this.changed();
      });
      try {
        await watch.done;
      } catch (error) {
        if (this.watch !== watch) return;
        this.elements.failed(error);
        if (![kResourceExhausted, kOutOfRange, kUnavailable].includes(error.code)) return;
      }
      await new Promise(done => setTimeout(done, kWatchAgain));
      if (this.watch !== watch) return;
      this.changed();
    }
  }

  close() {
    this.watch?.cancel();
    this.frame?.cancel();
    this.selection.frame?.cancel();
    this.selection.clear();
    this.prefetching?.cancel();
    this.name = this.camera = this.watch = this.known = this.revision = undefined;
    this.cells.clear();
    this.context.clearRect(0, 0, this.elements.picture.width, this.elements.picture.height);
  }

  // The picture is out of date.
  changed() {
    this.wanted = true;
    this.last = performance.now();
    if (!this.running && !document.hidden) this.#run();
  }

  setMode(mode) { this.mode = mode; if (this.camera) this.changed(); }
  showBoxes(shown) { this.cells.shown = shown; if (this.camera) this.#draw(); }
  showAll() { this.camera?.home(); this.changed(); }

  // node: 0, or one whose place is drawn over the picture; point: (3), or undefined.
  select(node, point) {
    this.selection.node = node;
    this.selection.point = point;
    this.outlineWanted = true;
    if (this.camera && !this.running && !document.hidden) this.#run();
  }

  async #run() {
    this.running = true;
    try {
      while ((this.wanted || this.outlineWanted) && this.camera && !document.hidden) {
        if (!this.wanted) {
          await this.#outline(1);
          continue;
        }
        this.wanted = false;
        await this.#cast(this.coarse, []);
        for (let finer = this.coarse; finer > 1 && await this.#rests();) await this.#cast(finer = finer >> 1, []);
        if (await this.#rests()) await this.#cast(1, kFinest);
      }
    } catch (error) {
      if (this.camera) this.elements.failed(error);
    } finally {
      this.running = false;
    }
  }

  // Of the node that is selected, if there is one. A node that is gone has none.
  async #outline(coarse) {
    const {name, camera, selection} = this;
    if (!camera) return;
    this.outlineWanted = false;
    if (!selection.node && !selection.point) return selection.erase();
    const pixels = await selection.draw(this.connection, name, camera, coarse).catch(error => {
      if (this.camera !== camera) return undefined;
      selection.erase();
      if (error.code === kNotFound) return 0;
      throw error;
    });
    if (pixels !== undefined && this.camera === camera) this.elements.outlined(pixels);
  }

  // Waits until the camera rests; returns false if a new picture is wanted instead.
  async #rests() {
    const left = () => this.last + kRest - performance.now();
    while (!this.wanted && this.camera && left() > 0) await new Promise(done => setTimeout(done, Math.min(left(), 20)));
    return !this.wanted && this.camera !== undefined;
  }

  async #cast(coarse, samples) {
    const {picture} = this.elements;
    const {name, camera, mode} = this;
    const begun = performance.now();
    this.frame = castFrame(this.connection, name, camera, {
      width: Math.ceil(picture.width / coarse), height: Math.ceil(picture.height / coarse), samples, mode});
    const frame = await this.frame.done;
    if (this.camera !== camera) return;
    const image = await createImageBitmap(shade(frame, mode, camera));
    this.context.imageSmoothingEnabled = coarse > 1;
    this.context.drawImage(image, 0, 0, picture.width, picture.height);
    this.#draw();
    ++this.frames;
    picture.dataset.frames = this.frames;
    picture.dataset.coarse = samples.length ? 'none' : coarse;
    if (this.opened) {
      picture.dataset.firstFrame = Math.round(performance.now() - this.opened);
      this.opened = undefined;
    }
    if (samples.length === 0) await this.#outline(coarse);
    if (coarse === this.coarse) this.#adapt(performance.now() - begun);
  }

  // So that frames keep up with the hand.
  #adapt(took) {
    if (this.coarse === kFirst) this.coarse = kCoarsest;
    else if (took > 2 * kSmooth && this.coarse < kCoarsest) this.coarse *= 2;
    else if (took < kSmooth / 3 && this.coarse > 1) this.coarse /= 2;
  }

  #draw() {
    if (this.cells.draw(this.camera)) requestAnimationFrame(() => { if (this.camera) this.#draw(); });
  }

  async #refresh() {
    if (!this.camera || document.hidden || this.refreshing) return;
    const {name, connection: {built}, revision} = this;
    const known = `${name} ${built} ${revision}`;
    if (built !== undefined && known === this.known) return;
    this.refreshing = true;
    try {
      const stats = await this.connection.stats(name);
      if (this.name !== name) return;
      await this.cells.update(this.connection, name);
      if (this.name !== name) return;
      this.#draw();
      this.known = known;
      this.#tell(stats);
    } catch (error) {
      this.elements.failed(error);
    } finally {
      this.refreshing = false;
    }
  }

  #tell(stats) {
    const {triangles_built: built = 0, triangles_total: total = 0, instances_entered: entered = 0,
      instances_total: instances = 0} = stats;
    this.elements.built.replaceChildren(...describe({
      'Revision': number(stats.revision.revision),
      'Triangles built': `${number(built)} of ${number(total)}`,
      'Nodes entered': `${number(entered)} of ${number(instances)}`,
      'Deferred cells': number(this.cells.total),
      'Tree bytes': number(stats.bytes_trees ?? 0),
    }));
  }

  #press(x, y) {
    const {picture: {width, height}} = this.elements;
    this.elements.pressed(this.camera.ray(x, y, width, height), [x, y]);
  }

  async prefetch(tell) {
    this.prefetching = this.connection.prefetch(this.name, answer =>
      tell(`${number(answer.triangles_done ?? 0)} of ${number(answer.triangles_total ?? 0)} triangles`));
    await this.prefetching.done;
  }

  async cool() {
    const answer = await this.connection.cool(this.name);
    return answer.bytes_freed ?? 0;
  }

  #listen() {
    const {picture} = this.elements;
    const pointers = new Map();
    let moved = 0;
    picture.addEventListener('pointerdown', event => {
      picture.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, event);
      if (pointers.size === 1) moved = 0;
    });
    picture.addEventListener('pointermove', event => {
      const before = pointers.get(event.pointerId);
      if (!before || !this.camera) return;
      const x = event.clientX - before.clientX, y = event.clientY - before.clientY;
      moved += Math.abs(x) + Math.abs(y);
      if (moved < kPress) return;
      if (pointers.size > 1) this.#pinch(pointers, event);
      else if (event.shiftKey || event.buttons > 1) this.camera.move(x / picture.clientHeight, y / picture.clientHeight);
      else this.camera.turn(-x * 0.008, y * 0.008);
      pointers.set(event.pointerId, event);
      this.changed();
    });
    const end = event => {
      pointers.delete(event.pointerId);
      if (event.type !== 'pointerup' || moved >= kPress || !this.camera) return;
      const box = picture.getBoundingClientRect();
      const pixel = (at, size, pixels) => Math.min(pixels - 1, Math.max(0, Math.floor(at / size * pixels)));
      this.#press(pixel(event.clientX - box.left, box.width, picture.width),
        pixel(event.clientY - box.top, box.height, picture.height));
    };
    picture.addEventListener('pointerup', end);
    picture.addEventListener('pointercancel', end);
    picture.addEventListener('contextmenu', event => event.preventDefault());
    picture.addEventListener('wheel', event => {
      event.preventDefault();
      this.camera?.zoom(Math.exp(event.deltaY * 0.0012));
      this.changed();
    }, {passive: false});
    picture.addEventListener('keydown', event => this.#key(event));
  }

  #pinch(pointers, event) {
    const [other] = [...pointers.values()].filter(one => one.pointerId !== event.pointerId);
    const before = pointers.get(event.pointerId);
    const apart = a => Math.hypot(a.clientX - other.clientX, a.clientY - other.clientY);
    this.camera.zoom(apart(before) / Math.max(1, apart(event)));
  }

  #key(event) {
    const step = event.shiftKey ? 0.3 : 0.1;
    const acts = {
      ArrowLeft: () => this.camera.turn(-step, 0),
      ArrowRight: () => this.camera.turn(step, 0),
      ArrowUp: () => this.camera.turn(0, step),
      ArrowDown: () => this.camera.turn(0, -step),
      '+': () => this.camera.zoom(0.9),
      '=': () => this.camera.zoom(0.9),
      '-': () => this.camera.zoom(1 / 0.9),
      Home: () => this.camera.home(),
    };
    const {picture} = this.elements;
    if (!this.camera) return;
    if (event.key === 'Enter') {
      this.#press(picture.width >> 1, picture.height >> 1);
    } else if (acts[event.key]) {
      acts[event.key]();
      this.changed();
    } else {
      return;
    }
    event.preventDefault();
  }
}
