// The server's metrics, in Prometheus' text format.

// A map from the name of a metric to its samples: {labels, value}.
export function parse(text) {
  const metrics = new Map();
  for (const line of text.split('\n')) {
    const match = /^([a-zA-Z_:][\w:]*)(?:\{(.*)\})? (\S+)$/.exec(line);
    if (!match) continue;
    const labels = Object.fromEntries([...(match[2] ?? '').matchAll(/(\w+)="((?:[^"\\]|\\.)*)"/g)].map(m => [m[1], m[2]]));
    if (!metrics.has(match[1])) metrics.set(match[1], []);
    metrics.get(match[1]).push({labels, value: Number(match[3].replace('+Inf', 'Infinity'))});
  }
  return metrics;
}

export const total = (metrics, name, where = () => true) =>
  (metrics.get(name) ?? []).filter(({labels}) => where(labels)).reduce((sum, {value}) => sum + value, 0);

// The upper bound of the bucket in which the quantile of what came between two scrapes lies; 0: nothing came.
export function quantileBetween(before, now, histogram, part) {
  const counts = new Map();
  const count = (metrics, sign) => {
    for (const {labels, value} of metrics.get(`${histogram}_bucket`) ?? [])
      counts.set(labels.le, (counts.get(labels.le) ?? 0) + sign * value);
  };
  count(now, 1);
  count(before, -1);
  const all = counts.get('+Inf') ?? 0;
  if (all <= 0) return 0;
  const bounds = [...counts].map(([le, n]) => [le === '+Inf' ? Infinity : Number(le), n]).sort((a, b) => a[0] - b[0]);
  return bounds.find(([, n]) => n >= part * all)[0];
}
