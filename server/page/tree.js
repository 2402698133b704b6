// A tree of nodes by the pattern of ARIA. Only the rows that are in view are elements of the page, so that a node may
// have 100,000 children.
import {nameParts} from './names.js';

const kBeyond = 4;  // rows above and below those in view
const kDeepest = 12;  // levels that are moved to the right
const kTypedWithin = 700;  // milliseconds between the letters of a word that is typed

export class Tree {
  // table: a NodeTable. choose(id): a node was chosen by hand.
  constructor(element, table, choose) {
    this.element = element;
    this.table = table;
    this.choose = choose;
    this.body = document.createElement('div');
    this.body.setAttribute('role', 'none');
    this.body.className = 'rows';
    this.drawn = new Map();  // id: the element of its row
    element.append(this.body);
    this.close();
    element.addEventListener('scroll', () => this.#draw());
    element.addEventListener('keydown', event => this.#key(event));
    element.addEventListener('focus', () => {
      if (!this.active) this.active = this.selected || this.rows.ids[0];
      this.#draw();
    });
    element.addEventListener('click', event => this.#click(event));
    new ResizeObserver(() => this.#draw()).observe(element);
  }

  close() {
    this.open = new Set();  // nodes whose children are shown
    this.rows = {ids: [], levels: [], positions: [], sizes: []};
    this.active = this.selected = 0;
    this.typed = '';
    this.opened = false;  // whether the first nodes were opened
    this.element.scrollTop = 0;
    this.#draw();
  }

  // The table has changed.
  update() {
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => {
      this.asked = undefined;
      this.#openFirst();
      this.#layOut();
    });
  }

  // Opens what is above the node, and shows it as selected; 0: none is.
  select(id) {
    this.selected = id;
    if (id) {
      this.active = id;
      for (const above of this.table.above(id)) this.open.add(above);
    }
    this.#layOut();
    if (id) this.#scrollTo(this.rows.ids.indexOf(id), true);
  }

  // A single root is opened, and its only child, until there is something to choose from.
  #openFirst() {
    if (this.opened) return;
    for (let at = 0, below = this.table.childrenOf(0); below.size > 0; below = this.table.childrenOf(at)) {
      this.opened = true;
      if (below.size > 1) return;
      [at] = below;
      this.open.add(at);
    }
  }

  #layOut() {
    const {table, open} = this;
    const rows = {ids: [], levels: [], positions: [], sizes: []};
    const stack = [{siblings: table.childrenOf(0), each: table.childrenOf(0).values(), position: 0}];
    while (stack.length) {
      const top = stack.at(-1);
      const {value: id, done} = top.each.next();
      if (done) {
        stack.pop();
        continue;
      }
      rows.ids.push(id);
      rows.levels.push(stack.length);
      rows.positions.push(++top.position);
      rows.sizes.push(top.siblings.size);
      if (!open.has(id)) continue;
      const siblings = table.childrenOf(id);
      stack.push({siblings, each: siblings.values(), position: 0});
    }
    this.rows = rows;
    if (this.active && !table.has(this.active)) this.active = 0;
    this.#draw();
  }

  // In pixels; it grows with the text.
  #height() { return parseFloat(getComputedStyle(this.element).lineHeight); }

  #draw() {
    const {element, body, rows: {ids}} = this;
    const height = this.#height();
    body.style.height = `${ids.length * height}px`;
    const first = Math.max(0, Math.floor(element.scrollTop / height) - kBeyond);
    const last = Math.min(ids.length, Math.ceil((element.scrollTop + element.clientHeight) / height) + kBeyond);
    const shown = Array.from({length: Math.max(0, last - first)}, (_, i) => this.#row(first + i, height));
    // What aria-activedescendant names is there even when it is out of view.
    const active = this.active ? ids.indexOf(this.active) : -1;
    if (active >= 0 && active < first) shown.unshift(this.#row(active, height));
    if (active >= last) shown.push(this.#row(active, height));
    // A row that is pressed stays until it is released, or it would get no click.
    const isSame = shown.length === body.childElementCount && shown.every((row, i) => row === body.children[i]);
    if (!isSame) body.replaceChildren(...shown);
    this.drawn = new Map(shown.map(row => [Number(row.dataset.node), row]));
    if (active >= 0) element.setAttribute('aria-activedescendant', rowId(this.active));
    else element.removeAttribute('aria-activedescendant');
  }

  // The element that is there already, if it says the same.
  #row(index, height) {
    const {ids, levels, positions, sizes} = this.rows;
    const id = ids[index];
    const expanded = this.table.childrenOf(id).size ? String(this.open.has(id)) : undefined;
    const attributes = {
      'aria-level': levels[index], 'aria-posinset': positions[index], 'aria-setsize': sizes[index],
      'aria-selected': id === this.selected, ...(expanded && {'aria-expanded': expanded}),
    };
    const name = this.table.name(id);
    const said = JSON.stringify([attributes, name, id === this.active, index, height]);
    const known = this.drawn.get(id);
    if (known?.said === said) return known;
    const row = document.createElement('div'), mark = document.createElement('span');
    row.said = said;
    row.id = rowId(id);
    row.dataset.node = id;
    row.setAttribute('role', 'treeitem');
    for (const [key, value] of Object.entries(attributes)) row.setAttribute(key, value);
    row.classList.toggle('active', id === this.active);
    row.style.top = `${index * height}px`;
    row.style.paddingInlineStart = `${Math.min(levels[index] - 1, kDeepest)}rem`;
    mark.className = 'mark';
    mark.setAttribute('aria-hidden', 'true');
    mark.textContent = expanded === 'true' ? '▾' : expanded ? '▸' : '';
    row.append(mark, ...nameParts(id, name));
    return row;
  }

  #scrollTo(index, toMiddle = false) {
    if (index < 0) return;
    const {element} = this;
    const height = this.#height();
    const top = index * height;
    const isSeen = top >= element.scrollTop && top + height <= element.scrollTop + element.clientHeight;
    if (!isSeen && toMiddle) element.scrollTop = top - (element.clientHeight - height) / 2;
    else if (top < element.scrollTop) element.scrollTop = top;
    else if (!isSeen) element.scrollTop = top + height - element.clientHeight;
    this.#draw();
  }

  #activate(index) {
    const {ids} = this.rows;
    if (ids.length === 0) return;
    const at = Math.max(0, Math.min(ids.length - 1, index));
    this.active = ids[at];
    this.#scrollTo(at);
  }

  #setOpen(id, isOpen) {
    if (isOpen) this.open.add(id);
    else this.open.delete(id);
    this.#layOut();
  }

  #click(event) {
    const row = event.target.closest('[role=treeitem]');
    if (!row) return;
    const id = Number(row.dataset.node);
    this.active = id;
    if (event.target.classList.contains('mark') && this.table.childrenOf(id).size) this.#setOpen(id, !this.open.has(id));
    else this.choose(id);
  }

  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const {rows: {ids}, table, active} = this;
    const at = ids.indexOf(active);
    const page = Math.max(1, Math.floor(this.element.clientHeight / this.#height()) - 1);
    const hasChildren = table.childrenOf(active).size > 0, isOpen = this.open.has(active);
    const acts = {
      ArrowDown: () => this.#activate(at + 1),
      ArrowUp: () => this.#activate(at - 1),
      PageDown: () => this.#activate(at + page),
      PageUp: () => this.#activate(at - page),
      Home: () => this.#activate(0),
      End: () => this.#activate(ids.length - 1),
      ArrowRight: () => {
        if (hasChildren && isOpen) this.#activate(at + 1);
        else if (hasChildren) this.#setOpen(active, true);
      },
      ArrowLeft: () => {
        if (hasChildren && isOpen) this.#setOpen(active, false);
        else if (table.parent(active)) this.#activate(ids.indexOf(table.parent(active)));
      },
      Enter: () => { if (active) this.choose(active); },
      ' ': () => { if (active) this.choose(active); },
    };
    if (acts[event.key]) acts[event.key]();
    else if ([...event.key].length === 1) this.#type(event.key, event.timeStamp, at);
    else return;
    event.preventDefault();
  }

  // Goes to the next row whose name begins with what is typed.
  #type(letter, time, at) {
    const isNew = time - this.typedAt > kTypedWithin;
    this.typed = (isNew ? '' : this.typed) + letter.toLowerCase();
    this.typedAt = time;
    const {ids} = this.rows;
    const begin = this.typed.length > 1 ? at : at + 1;
    for (let i = 0; i < ids.length; ++i) {
      const index = (Math.max(0, begin) + i) % ids.length;
      if (this.table.name(ids[index]).toLowerCase().startsWith(this.typed)) return this.#activate(index);
    }
  }
}

const rowId = id => `node-${id}`;
