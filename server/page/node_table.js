// The names and parents of a scene's nodes. They are read in the order of their ids, a piece at a time; what changes
// meanwhile and later is read again.

const kPiece = 512;  // ids that one call takes
const kLongestGap = 1000000;  // ids without a node, after which there are no more: ids are given in order, never again
const kMostNodes = 200000;
const kMostCharacters = 1 << 25;  // of all names
const kMostChanged = 65536;  // ids that wait to be read again; where there are more, all is read anew
const kMostLevels = 1024;
const kPause = 1000;  // milliseconds before a call is tried again
const kResourceExhausted = 8, kUnavailable = 14;
const kMostShown = 8, kLongestShown = 64;  // of a path: names, and characters of each

export class NodeTable {
  // changed() is told whenever something is different, failed(error) of the end of reading by an error.
  constructor(connection, changed, failed) {
    this.connection = connection;
    this.changed = changed;
    this.failed = failed;
    this.close();
  }

  close() {
    this.reading = undefined;  // identifies the reading that is under way
    this.scene = undefined;
    this.nodes = new Map();     // id: {name, parent}
    this.children = new Map();  // id, or 0 for the roots: a Set of ids
    this.changedIds = new Set();
    this.characters = 0;
    this.total = 0;             // nodes of the scene, as far as is known
    this.complete = false;      // all nodes are here
    this.full = false;          // there is no room for more
  }

  // Reads all nodes of the scene. Call it after a watch has begun, so that no change is missed.
  open(scene) {
    this.close();
    this.scene = scene;
    this.reading = {first: 1, found: 0, last: 0, ended: false};
    this.#read(this.reading).catch(error => { if (this.scene === scene) this.failed(error); });
  }

  // updates: of a message WatchSceneResponse.
  follow(updates) {
    if (!this.scene) return;
    for (const {put_node: put, delete_node: gone} of updates) {
      if (put) this.changedIds.add(put.node);
      if (gone) this.changedIds.add(gone.node);
    }
    if (this.changedIds.size > kMostChanged) this.open(this.scene);
    this.wake?.();
  }

  has(id) { return this.nodes.has(id); }
  name(id) { return this.nodes.get(id)?.name ?? ''; }
  parent(id) { return this.nodes.get(id)?.parent ?? 0; }
  childrenOf(id) { return this.children.get(id) ?? new Set(); }

  // The ids of the nodes above, the nearest first. A node that was moved while it was read may have itself above it,
  // until it is read again.
  above(id) {
    const ids = [];
    for (let at = this.parent(id); at && this.nodes.has(at) && ids.length < kMostLevels; at = this.parent(at)) ids.push(at);
    return ids;
  }

  // The names of the nodes above, a root's first. The last ones, shortened, if there are many.
  path(id) {
    const above = this.above(id);
    const names = above.slice(0, kMostShown).reverse().map(one => shorten(this.name(one) || String(one)));
    return above.length > kMostShown ? ['…', ...names] : names;
  }

  // The nodes whose name has the text, in any case, and the one whose id it is: {ids, total}, at most `most` ids.
  search(text, most) {
    const id = /^\d+$/.test(text) ? Number(text) : 0;
    const ids = this.nodes.has(id) ? [id] : [];
    const fits = new RegExp(text.replace(/[\\^$.*+?()[\]{}|/]/g, '\\$&'), 'iu');
    let total = ids.length;
    for (const [one, {name}] of this.nodes) {
      if (one === id || !fits.test(name)) continue;
      if (++total <= most) ids.push(one);
    }
    return {ids, total};
  }

  // Reads a node and those above it, if they are not here yet. Returns whether it exists.
  async need(id) {
    const {scene} = this;
    for (let at = id, level = 0; at && !this.nodes.has(at) && level < kMostLevels; at = this.parent(at), ++level) {
      const {nodes: [node]} = await this.connection.nodes(scene, [at]);
      if (this.scene !== scene || !node?.id) break;
      this.#put(node);
      this.changedIds.add(at);  // read again, in order with the other changes
    }
    this.wake?.();
    this.changed();
    return this.nodes.has(id);
  }

  async #read(reading) {
    const current = () => this.reading === reading;
    this.total = (await this.connection.scene(this.scene)).scene.nodes ?? 0;
    while (current()) {
      while (document.hidden && current()) await pause(kPause);
      if (this.changedIds.size === 0 && reading.ended) await new Promise(done => { this.wake = done; });
      if (!current()) return;
      try {
        await (this.changedIds.size > 0 ? this.#readChanged(current) : this.#readNext(reading, current));
      } catch (error) {
        if (!current()) return;
        if (error.code !== kUnavailable && error.code !== kResourceExhausted) throw error;
        await pause(kPause);
      }
      if (current()) this.changed();
    }
  }

  async #readChanged(current) {
    const ids = [...this.changedIds].slice(0, kPiece);
    const {nodes} = await this.connection.nodes(this.scene, ids);
    if (!current()) return;
    ids.forEach((id, i) => {
      this.changedIds.delete(id);
      const node = nodes[i];
      if (!node.id) this.#remove(id);
      else if (this.nodes.has(id) || !this.full) this.#put(node);
    });
    if (this.complete) this.total = this.nodes.size;
    this.#bound();
  }

  async #readNext(reading, current) {
    if (this.total === 0) return this.#end(reading, true);
    const ids = Array.from({length: kPiece}, (_, i) => reading.first + i);
    const found = (await this.connection.nodes(this.scene, ids)).nodes.filter(node => node.id);
    if (!current()) return;
    reading.first += kPiece;
    reading.found += found.length;
    if (found.length) {
      reading.last = reading.first;
      found.forEach(node => this.#put(node));
      this.#bound();
      // Nodes that came since have ids above those that were there.
      if (reading.found >= this.total || this.full) this.#end(reading, !this.full || reading.found >= this.total);
      return;
    }
    // Some may have been deleted since they were counted.
    const {nodes = 0} = (await this.connection.scene(this.scene)).scene;
    if (!current()) return;
    this.total = nodes;
    const complete = this.nodes.size >= nodes;
    if (complete || reading.first - reading.last > kLongestGap) this.#end(reading, complete);
  }

  #end(reading, complete) {
    reading.ended = true;
    this.complete = complete;
    if (complete) this.total = this.nodes.size;
  }

  #bound() { this.full = this.nodes.size >= kMostNodes || this.characters >= kMostCharacters; }

  #put({id, name = '', parent = 0}) {
    const known = this.nodes.get(id);
    if (known && known.parent !== parent) this.#leave(known.parent, id);
    if (!known || known.parent !== parent) {
      if (!this.children.has(parent)) this.children.set(parent, new Set());
      this.children.get(parent).add(id);
    }
    this.characters += name.length - (known?.name.length ?? 0);
    this.nodes.set(id, {name, parent});
  }

  // With all below it.
  #remove(id) {
    if (this.nodes.has(id)) this.#leave(this.parent(id), id);
    const gone = [id];
    while (gone.length) {
      const one = gone.pop();
      this.characters -= this.name(one).length;
      this.nodes.delete(one);
      const below = this.children.get(one) ?? [];
      this.children.delete(one);
      gone.push(...below);
    }
  }

  #leave(parent, id) {
    const siblings = this.children.get(parent);
    siblings?.delete(id);
    if (siblings?.size === 0) this.children.delete(parent);
  }
}

const pause = milliseconds => new Promise(done => setTimeout(done, milliseconds));
const shorten = name => name.length > kLongestShown ? `${name.slice(0, kLongestShown)}…` : name;
