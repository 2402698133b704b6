// The nodes of the scene that is shown: their tree, the search, and the one that is selected.
import {describe, number} from './curve.js';
import {pathOf} from './names.js';
import {NodeSearch} from './node_search.js';
import {NodeTable} from './node_table.js';
import {Tree} from './tree.js';

export class Nodes {
  // elements: tree, field, found, note, state and facts. selected(id): another node is; 0: none.
  constructor(connection, elements, selected) {
    this.elements = elements;
    this.selectedChanged = selected;
    this.table = new NodeTable(connection, () => this.#changed(), error => {
      this.#say(`the nodes cannot be read: ${error.message}`, true);
    });
    const choose = id => this.select(id);
    this.tree = new Tree(elements.tree, this.table, choose);
    this.search = new NodeSearch({field: elements.field, list: elements.found, note: elements.note}, this.table, choose);
    this.close();
  }

  close() {
    this.scene = undefined;
    this.selected = 0;
    this.pixels = undefined;
    this.table.close();
    this.tree.close();
    this.search.clear();
    this.#say('');
    this.#tell();
  }

  // Reads the nodes of a scene that is watched from now on. What is selected and open stays, if the scene is the same.
  open(scene) {
    if (this.scene !== scene) this.close();
    this.scene = scene;
    this.#say('reading');
    this.table.open(scene);
  }

  // updates: of a message WatchSceneResponse.
  follow(updates) { this.table.follow(updates); }

  // 0: no node.
  async select(id) {
    const {scene} = this;
    this.selected = id;
    this.pixels = undefined;
    this.selectedChanged(id);
    this.tree.select(id);
    this.#tell();
    if (!id || this.table.has(id)) return;
    await this.table.need(id);
    if (this.scene !== scene || this.selected !== id) return;
    this.tree.select(id);
    this.#tell();
  }

  // How many pixels of the picture the selected node takes, others before it or not.
  setPixels(count) {
    this.pixels = count;
    this.#tell();
  }

  #changed() {
    const {table} = this;
    if (!this.scene) return;
    if (this.selected && table.complete && table.changedIds.size === 0 && !table.has(this.selected)) this.select(0);
    const have = number(table.nodes.size);
    this.#say(table.complete ? (table.nodes.size === 1 ? '1 node' : `${have} nodes`) :
      table.full ? `the first ${have} of ${number(table.total)} nodes are listed and searched` :
      `${have} of ${number(table.total)} nodes are read`);
    this.tree.update();
    this.search.update();
    this.#tell();
  }

  #say(text, bad = false) {
    const {state} = this.elements;
    state.textContent = text;
    state.className = bad ? 'bad' : 'quiet';
  }

  #tell() {
    const {selected, table, pixels} = this;
    const path = table.path(selected);
    const facts = !selected ? {} : {
      'Selected': selected,
      'Name': table.name(selected) || 'no name',
      'Below': path.length ? pathOf(path) : 'no node: it is a root',
      'Children': number(table.childrenOf(selected).size),
      'In the picture': pixels === undefined ? 'not known yet' : pixels === 0 ? 'not in view' : `${number(pixels)} pixels`,
    };
    this.elements.facts.replaceChildren(...describe(facts));
  }
}
