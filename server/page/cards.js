// The scenes as cards. Their pictures show what is built, and build nothing.
import {Camera} from './camera.js';
import {number} from './curve.js';
import {castFrame} from './frames.js';
import {shade} from './shade.js';

const kWidth = 160, kHeight = 100;
const kPictures = 24;  // more cards have none

export class Cards {
  constructor(connection, list, open) {
    this.connection = connection;
    this.list = list;
    this.open = open;
    this.cards = new Map();  // by name of the scene
  }

  // Returns how many there are.
  async update() {
    const scenes = await this.connection.scenes();
    const names = new Set(scenes.map(scene => scene.name));
    for (const [name, card] of this.cards) {
      if (names.has(name)) continue;
      card.item.remove();
      this.cards.delete(name);
    }
    let left = kPictures;
    for (const scene of scenes) {
      const card = this.cards.get(scene.name) ?? this.#add(scene.name);
      card.facts.textContent = scene.unread ? 'on disk' :
        `${number(scene.triangles_instanced ?? 0)} triangles, revision ${number(scene.head?.revision ?? 0)}`;
      card.scene = scene.unread ? undefined : scene;
      if (scene.unread) card.say('not read yet');
      if (scene.unread || document.hidden) continue;
      if (left-- <= 0) {
        card.say(`pictures of ${kPictures} scenes are shown`);
        continue;
      }
      await this.#draw(scene, card);
    }
    return scenes.length;
  }

  // The message Scene as it was seen last; undefined: not yet.
  scene(name) { return this.cards.get(name)?.scene; }

  select(name) {
    for (const [other, card] of this.cards) card.button.setAttribute('aria-current', other === name);
  }

  async #draw(scene, card) {
    const known = `${this.connection.built} ${scene.head?.revision}`;
    if (this.connection.built !== undefined && known === card.known) return;
    const stats = await this.connection.stats(scene.name);
    const share = stats.triangles_total ? Math.round(100 * (stats.triangles_built ?? 0) / stats.triangles_total) : 0;
    card.built.textContent = `${share} % built`;
    const camera = new Camera(scene, kWidth / kHeight);
    const frame = await castFrame(this.connection, scene.name, camera,
      {width: kWidth, height: kHeight, mode: 'lit', build: 'BUILD_MODE_BUILT_ONLY'}).done;
    card.canvas.getContext('2d').putImageData(shade(frame, 'lit', camera), 0, 0);
    card.say(stats.triangles_built ? '' : 'nothing built yet');
    card.known = known;
  }

  #add(name) {
    const item = document.createElement('li');
    const button = document.createElement('button');
    const canvas = document.createElement('canvas');
    const [title, facts, built] = ['name', 'quiet', 'quiet'].map(kind => {
      const span = document.createElement('span');
      span.className = kind;
      return span;
    });
    button.type = 'button';
    canvas.width = kWidth;
    canvas.height = kHeight;
    canvas.setAttribute('aria-hidden', 'true');
    title.textContent = name.split('/').pop();
    const screen = document.createElement('span'), note = document.createElement('span');
    screen.className = 'screen-of-card';
    note.className = 'note';
    note.textContent = 'no picture yet';
    screen.append(canvas, note);
    button.append(screen, title, facts, built);
    button.addEventListener('click', () => this.open(name));
    item.append(button);
    this.list.append(item);
    // What stands in the place of a picture; empty: there is one.
    const say = text => {
      note.textContent = text;
      note.hidden = !text;
    };
    const card = {item, button, canvas, facts, built, say};
    this.cards.set(name, card);
    return card;
  }
}
