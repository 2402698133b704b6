// What the page asks of the server.
import {Messages} from './protobuf.js';
import {Tunnel} from './tunnel.js';

const kToken = 'sightline-token';
const kScenes = '/sightline.v1.SceneService/';
const kQueries = '/sightline.v1.RayQueryService/';
const kServer = '/sightline.v1.ServerService/';

// A token is sent to this machine, or encrypted, or not at all.
const isPrivate = location.protocol === 'https:' ||
  ['localhost', '127.0.0.1', '[::1]'].includes(location.hostname);

// What a header can hold.
const kVisible = /^[!-~]+$/;

// A browser may forbid to store anything: the page then asks again when it is loaded again.
function storedToken() {
  try {
    return sessionStorage.getItem(kToken);
  } catch {
    return null;
  }
}

function storeToken(token) {
  try {
    sessionStorage.setItem(kToken, token);
  } catch { /* see above */ }
}

export class Connection {
  static async open(state) {
    const descriptors = await fetch('/page/messages.pb');
    return new Connection(new Messages(new Uint8Array(await descriptors.arrayBuffer())), state);
  }

  constructor(messages, state) {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    this.tunnel = new Tunnel(messages, `${scheme}://${location.host}/`, state);
    const token = storedToken();
    if (token && isPrivate && kVisible.test(token)) this.tunnel.authorization = `Bearer ${token}`;
  }

  // Kept until the tab is closed.
  useToken(token) {
    if (!isPrivate) throw new Error('the token is not sent: this page is not encrypted, and not of this machine');
    if (!kVisible.test(token)) throw new Error('this is no token: it has a character other than visible ASCII, or none');
    storeToken(token);
    this.tunnel.authorization = `Bearer ${token}`;
  }

  serverInfo() { return this.tunnel.call(`${kServer}GetServerInfo`, {}); }
  log(after) { return this.tunnel.call(`${kServer}ReadLog`, {after}); }
  scene(name) { return this.tunnel.call(`${kScenes}GetScene`, {name}); }
  stats(scene) { return this.tunnel.call(`${kScenes}GetSceneStats`, {scene}); }
  deferredCells(scene, max) { return this.tunnel.call(`${kScenes}ListDeferredCells`, {scene, max_cells: max}); }
  cool(scene) { return this.tunnel.call(`${kScenes}CoolScene`, {scene}); }
  nodes(scene, ids) { return this.tunnel.call(`${kScenes}BatchGetNodes`, {scene, ids}); }
  cast(request) { return this.tunnel.call(`${kQueries}CastRays`, request); }

  // Answers of StreamCastRays to requests of one revision, in order.
  castAll(requests, each) {
    return this.tunnel.stream(`${kQueries}StreamCastRays`,
      requests.map((request, chunk) => ({chunk, request})), answer => each(answer.chunk ?? 0, answer.response));
  }

  // `each` gets how far it has come.
  prefetch(scene, each) { return this.tunnel.stream(`${kQueries}Prefetch`, [{scene}], each); }

  // `each` gets every new revision.
  watch(scene, each) { return this.tunnel.stream(`${kScenes}WatchScene`, [{scene}], each); }

  // The scenes of all projects that may be read.
  async scenes() {
    const all = [];
    let page = '';
    do {
      const answer = await this.tunnel.call(`${kScenes}ListScenes`, {parent: 'projects/default', page_token: page});
      all.push(...answer.scenes);
      page = answer.next_page_token ?? '';
    } while (page);
    return all;
  }
}
