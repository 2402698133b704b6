// What the server does now, from its metrics, each second.
import {drawCurve, number} from './curve.js';
import {parse, quantileBetween, total} from './metrics.js';

const kSeconds = 120;  // of a curve

const kCounters = [
  {name: 'Rays a second', value: (a, b, s) => (total(b, 'sightline_rays_total') - total(a, 'sightline_rays_total')) / s},
  {name: 'Batches, p99, ms', value: (a, b) => 1000 * quantileBetween(a, b, 'sightline_batch_seconds', 0.99)},
  {name: 'Rays in the queue', value: (a, b) => total(b, 'sightline_queue_rays')},
  {name: 'Cells built a second', value: (a, b, s) =>
    (total(b, 'sightline_cells_expanded_total') - total(a, 'sightline_cells_expanded_total')) / s},
  {name: 'Tree bytes', value: (a, b) => total(b, 'sightline_tree_bytes')},
  {name: 'Updates a second', value: (a, b, s) => (handled(b, 'ApplyUpdates') - handled(a, 'ApplyUpdates')) / s},
  {name: 'Memory, bytes', value: (a, b) => total(b, 'process_resident_memory_bytes')},
  {name: 'Processors', value: (a, b, s) =>
    (total(b, 'process_cpu_seconds_total') - total(a, 'process_cpu_seconds_total')) / s},
];

const handled = (metrics, method) =>
  total(metrics, 'grpc_server_handled_total', labels => labels.grpc_method === method);

export class Counters {
  // connection.built becomes a text that changes whenever something is built or dropped: what walks trees need not be
  // asked for again before.
  constructor(connection, list, streams) {
    this.connection = connection;
    this.streams = streams;
    this.rows = kCounters.map(counter => {
      const item = document.createElement('li');
      const title = document.createElement('div'), value = document.createElement('div');
      const canvas = document.createElement('canvas');
      title.className = 'quiet';
      title.textContent = counter.name;
      value.className = 'value';
      canvas.setAttribute('aria-hidden', 'true');
      item.append(title, value, canvas);
      list.append(item);
      return {counter, value, canvas, values: []};
    });
  }

  async update() {
    const reply = await fetch('/metrics');
    const now = {time: performance.now(), metrics: parse(await reply.text())};
    this.connection.built = `${total(now.metrics, 'sightline_cells_expanded_total')} ${total(now.metrics, 'sightline_tree_bytes')}`;
    if (this.before) {
      const seconds = (now.time - this.before.time) / 1000;
      for (const row of this.rows) {
        const value = row.counter.value(this.before.metrics, now.metrics, seconds);
        row.values.push(value);
        if (row.values.length > kSeconds) row.values.shift();
        row.value.textContent = number(value);
        drawCurve(row.canvas, row.values, kSeconds);
      }
      this.#showStreams(now.metrics);
    }
    this.before = now;
  }

  #showStreams(metrics) {
    const open = new Map();
    const count = (name, sign) => {
      for (const {labels, value} of metrics.get(name) ?? [])
        open.set(labels.grpc_method, (open.get(labels.grpc_method) ?? 0) + sign * value);
    };
    count('grpc_server_started_total', 1);
    count('grpc_server_handled_total', -1);
    const shown = [...open].filter(([, calls]) => calls > 0);
    this.streams.replaceChildren(...(shown.length ? shown : [['none', 0]]).map(([method, calls]) => {
      const item = document.createElement('li');
      item.textContent = calls > 0 ? `${method}: ${calls}` : method;
      return item;
    }));
  }
}
