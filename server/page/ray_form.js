// The ray that is cast by hand, or by a press on the picture, and the answer's columns.
import {describe} from './curve.js';
import {asText, castRay, readTriple} from './ray.js';

export class RayForm {
  // elements: form, origin, direction, state and answer. answered(hit): hit as castRay() has it, {} for a miss.
  constructor(connection, elements, answered) {
    this.connection = connection;
    this.elements = elements;
    this.answered = answered;
    elements.form.addEventListener('submit', event => {
      event.preventDefault();
      this.#cast();
    });
    this.open();
  }

  // scene: its name; undefined: none is shown.
  open(scene) {
    this.scene = scene;
    this.asked = undefined;  // identifies the last cast
    this.#say('');
    this.elements.answer.replaceChildren(...describe({'Nothing yet': 'press on the picture, or write a ray'}));
  }

  // pixel: [x, y] of the picture.
  async castPixel({origin, direction}, pixel) {
    this.elements.origin.value = asText(origin);
    this.elements.direction.value = asText(direction);
    await this.#cast(pixel);
  }

  async #cast(pixel) {
    const {elements, scene} = this;
    const asked = this.asked = {};
    try {
      for (const field of [elements.origin, elements.direction]) field.removeAttribute('aria-invalid');
      const origin = this.#read(elements.origin, 'origin'), direction = this.#read(elements.direction, 'direction');
      this.#say('asking');
      const hit = await castRay(this.connection, scene, origin, direction);
      if (this.asked !== asked) return;
      this.#say('');
      elements.answer.replaceChildren(...describe(facts(hit, pixel)));
      this.answered(hit);
    } catch (error) {
      if (this.asked !== asked) return;
      elements.answer.replaceChildren();
      this.#say(error.message, true);
    }
  }

  #read(field, name) {
    try {
      return readTriple(field.value, name);
    } catch (error) {
      field.setAttribute('aria-invalid', 'true');
      throw error;
    }
  }

  #say(text, bad = false) {
    const {state} = this.elements;
    state.textContent = text;
    state.className = bad ? 'bad' : 'quiet';
  }
}

function facts(hit, pixel) {
  const at = pixel && {'Pixel': pixel.join(', ')};
  if (hit.node === undefined) return {'Nothing': 'is hit', ...at};
  return {
    't': hit.t, 'Node': hit.node, 'Name': hit.name || 'no name', 'Primitive': hit.primitive,
    'Barycentric': asText(hit.barycentric), 'Normal': asText(hit.normal), 'Position': asText(hit.position),
    'Work': `${hit.work} steps and tests`, ...at,
  };
}
