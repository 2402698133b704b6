// The live page: scenes, one of them to orbit, what the server does, and its log.
import {Cards} from './cards.js';
import {Connection} from './connection.js';
import {Counters} from './counters.js';
import {number} from './curve.js';
import {Log} from './log.js';
import {Nodes} from './nodes.js';
import {RayForm} from './ray_form.js';
import {offerThemes} from './theme.js';
import {Viewer} from './viewer.js';

const kUnauthenticated = 16, kPermissionDenied = 7, kUnavailable = 14;
const kSecond = 1000;

const element = id => document.getElementById(id);

function say(text, bad = false) {
  element('state').textContent = text;
  element('state').className = bad ? 'bad' : 'quiet';
}

function failed(error) {
  if (error.code === kUnavailable) return;  // the state says so
  if (error.code === kUnauthenticated) element('token-form').hidden = false;
  say(error.message, true);
}

// Runs act() again and again, a pause after its end, while the page is seen.
async function repeat(pause, act) {
  for (;;) {
    if (!document.hidden) await act().catch(failed);
    await new Promise(done => setTimeout(done, pause));
  }
}

async function greet(connection) {
  const info = await connection.serverInfo();
  element('server').textContent =
    `${info.version}, ${info.threads} threads, ${info.simd_target}, policy ${info.policy}`;
  element('token-form').hidden = true;
}

const connection = await Connection.open(connected => {
  say(connected ? 'connected' : 'the server cannot be reached', !connected);
  if (connected) greet(connection).catch(failed);
}).catch(error => {
  say(`the page cannot be loaded: ${error.message}`, true);
  throw error;
});
const viewer = new Viewer(connection, {
  picture: element('picture'), boxes: element('boxes'), outline: element('outline'), built: element('built'), failed,
  pressed: (ray, pixel) => rayForm.castPixel(ray, pixel),
  watched: () => nodes.open(viewer.name),
  updated: updates => nodes.follow(updates),
  outlined: pixels => nodes.setPixels(pixels)});
let point;  // that a ray has hit
const nodes = new Nodes(connection, {
  tree: element('tree'), field: element('find'), found: element('found'), note: element('find-note'),
  state: element('nodes-state'), facts: element('selected')}, id => viewer.select(id, point));
const rayForm = new RayForm(connection, {
  form: element('ray-form'), origin: element('origin'), direction: element('direction'), state: element('ray-state'),
  answer: element('picked')}, hit => {
  point = hit.position;
  nodes.select(hit.node ?? 0).catch(failed);
  point = undefined;
});
const cards = new Cards(connection, element('cards'), show);
const counters = new Counters(connection, element('counters'), element('streams'));
const log = new Log(connection, element('log'));

// The scene's name is part of the address, so that it can be linked.
function show(name) { location.hash = name; }

// An address that nobody has made here may be no encoded text: it is then taken as it is, and the server says that
// there is no such scene.
function shown() {
  const text = location.hash.slice(1);
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

async function route() {
  const name = shown();
  element('viewer').hidden = !name;
  cards.select(name);
  element('action').textContent = '';
  nodes.close();
  rayForm.open(name);
  if (!name) return viewer.close();
  element('scene-name').textContent = name.split('/').pop();
  element('scene-name').focus({preventScroll: true});
  element('viewer').scrollIntoView({block: 'nearest'});
  await viewer.open(name, cards.scene(name)).catch(failed);
}

// A button's work; the button rests meanwhile.
function press(button, act) {
  const tell = text => { element('action').textContent = text; };
  element(button).addEventListener('click', async () => {
    element(button).disabled = true;
    try {
      await act(tell);
    } catch (error) {
      tell(error.message);
    } finally {
      element(button).disabled = false;
    }
  });
}

press('prefetch', async tell => { await viewer.prefetch(tell); tell('all trees are built'); viewer.changed(); });
press('cool', async tell => { tell(`${number(await viewer.cool())} bytes of trees dropped`); });
press('whole', async () => viewer.showAll());
element('close').addEventListener('click', () => show(''));
element('modes').addEventListener('change', event => viewer.setMode(event.target.value));
element('show-boxes').addEventListener('change', event => viewer.showBoxes(event.target.checked));
element('token-form').addEventListener('submit', event => {
  event.preventDefault();
  try {
    connection.useToken(element('token').value);
    greet(connection).then(() => { say('connected'); return route(); }, failed);
  } catch (error) {
    say(error.message, true);
  }
});
addEventListener('hashchange', route);
offerThemes(element('theme'));

const connected = () => connection.tunnel.socket.readyState === WebSocket.OPEN;
const unlessAway = act => async () => { if (connected()) await act(); };
repeat(kSecond, () => counters.update());
repeat(2 * kSecond, unlessAway(async () => {
  const count = await cards.update();
  cards.select(viewer.name);
  element('no-scenes').hidden = count > 0;
}));
let logMayBeRead = true;
repeat(kSecond, unlessAway(async () => {
  if (!logMayBeRead) return;
  await log.update().catch(error => {
    if (error.code !== kPermissionDenied) throw error;
    logMayBeRead = false;
    element('log').textContent = 'The log is for administrators of all scenes.';
  });
}));
// The first call needs an open socket.
while (!connected()) await new Promise(done => setTimeout(done, 20));
route();
