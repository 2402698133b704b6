// Numbers as text, and as small curves.

const kUnits = ['', ' k', ' M', ' G', ' T'];

export function number(value) {
  if (!Number.isFinite(value)) return 'more';
  if (Number.isInteger(value) && Math.abs(value) < 10000) return String(value);
  let unit = 0;
  while (Math.abs(value) >= 1000 && unit + 1 < kUnits.length) { value /= 1000; ++unit; }
  return `${value.toPrecision(3)}${kUnits[unit]}`;
}

// Rows of a <dl>; a value is a text or an element.
export const describe = facts => Object.entries(facts).flatMap(([name, value]) => {
  const term = document.createElement('dt'), detail = document.createElement('dd');
  term.textContent = name;
  detail.append(value);
  return [term, detail];
});

// The values from the oldest to the newest, over the whole canvas.
export function drawCurve(canvas, values, length) {
  const scale = window.devicePixelRatio;
  const width = canvas.width = canvas.clientWidth * scale, height = canvas.height = canvas.clientHeight * scale;
  const most = Math.max(...values.filter(Number.isFinite), 1e-9);
  const context = canvas.getContext('2d');
  context.strokeStyle = getComputedStyle(canvas).color;
  context.lineWidth = 1.5 * scale;
  context.lineJoin = 'round';
  context.beginPath();
  values.forEach((value, i) => {
    const x = (i + length - values.length) / (length - 1) * width;
    const y = height - 2 * scale - Math.min(value, most) / most * (height - 4 * scale);
    if (i === 0) context.moveTo(x, y);
    else context.lineTo(x, y);
  });
  context.stroke();
}
