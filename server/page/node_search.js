// The search for nodes by a part of their names, or by id.
import {nameParts, pathOf} from './names.js';

const kMost = 50;  // nodes that are listed

export class NodeSearch {
  // field, list and note are elements; choose(id): a node was chosen.
  constructor({field, list, note}, table, choose) {
    this.field = field;
    this.list = list;
    this.note = note;
    this.table = table;
    this.choose = choose;
    field.addEventListener('input', () => this.update());
    field.addEventListener('keydown', event => this.#fieldKey(event));
    list.addEventListener('keydown', event => this.#listKey(event));
    list.addEventListener('click', event => {
      const button = event.target.closest('button');
      if (button) choose(Number(button.dataset.node));
    });
  }

  clear() {
    this.field.value = '';
    this.update();
  }

  // Searches again, if there is something to search for.
  update() {
    const text = this.field.value.trim();
    this.list.hidden = !text;
    if (!text) {
      this.list.replaceChildren();
      this.shown = '';
      this.note.textContent = '';
      return;
    }
    const {ids, total} = this.table.search(text, kMost);
    const wanted = ids.join();
    if (wanted !== this.shown) this.list.replaceChildren(...ids.map(id => this.#item(id)));
    this.shown = wanted;
    this.list.hidden = total === 0;
    const rest = total - ids.length;
    this.note.textContent = total === 0 ? 'no node has this in its name' :
      rest > 0 ? `${ids.length} nodes, and ${rest} more: write more of the name` :
      total === 1 ? '1 node' : `${total} nodes`;
  }

  #item(id) {
    const item = document.createElement('li'), button = document.createElement('button');
    const path = pathOf(this.table.path(id));
    button.type = 'button';
    button.dataset.node = id;
    path.className = 'quiet path';
    button.append(...nameParts(id, this.table.name(id)), path);
    item.append(button);
    return item;
  }

  #fieldKey(event) {
    const [first] = this.list.querySelectorAll('button');
    if (event.key === 'ArrowDown') first?.focus();
    else if (event.key === 'Enter') first?.click();
    else if (event.key === 'Escape') this.clear();
    else return;
    event.preventDefault();
  }

  #listKey(event) {
    const buttons = [...this.list.querySelectorAll('button')];
    const at = buttons.indexOf(document.activeElement);
    if (event.key === 'ArrowDown') buttons[Math.min(at + 1, buttons.length - 1)].focus();
    else if (event.key === 'ArrowUp') (at > 0 ? buttons[at - 1] : this.field).focus();
    else if (event.key === 'Escape') {
      this.clear();
      this.field.focus();
    } else return;
    event.preventDefault();
  }
}
