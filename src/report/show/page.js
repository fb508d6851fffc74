'use strict';
(() => {
const data = JSON.parse(document.getElementById('data').textContent);
const canvas = document.getElementById('canvas'), context = canvas.getContext('2d');
const byId = id => document.getElementById(id);
const rows = [...document.querySelectorAll('tr[data-mode]')];
const size = byId('size'), speed = byId('speed'), pause = byId('pause'), caption = byId('caption');
const figure = data.figure, dimension = figure ? figure.dimension : 0;
const asked = new URLSearchParams(location.hash.slice(1));
let number = Math.min(Math.max((asked.get('mode') | 0) - 1, 0), data.modes.length - 1);
// In periods; a time in the address stops there.
let time = parseFloat(asked.get('t')) || 0;
let running = !asked.has('t') && !matchMedia('(prefers-reduced-motion: reduce)').matches;
let turned = [0.5, 0.35], last = 0, scale = 1, moves = true;
const grid = data.grid, axes = grid ? grid.axes : [], sliders = [...document.querySelectorAll('[data-axis]')];
const between = (from, to, share) => from + share * (to - from);
// What is drawn: the modes and the equilibrium where the sliders stand, and the values of the parameters in SI.
let missing = false, shown = data, si = axes.map((axis, k) => between(...axis.si, parseFloat(sliders[k].value)));
// The nodes about a place, each with its weight.
function corners(shares) {
  return axes.reduce((all, axis, k) => {
    const at = shares[k] * (axis.count - 1), low = Math.min(Math.floor(at), Math.max(axis.count - 2, 0)), rest = at - low;
    return all.flatMap(([node, weight]) => [[node * axis.count + low, weight * (1 - rest)], [node * axis.count + low + 1, weight * rest]]);
  }, [[0, 1]]).filter(([, weight]) => weight > 0);
}
// Linear between nodes; the nearest alone where modes are of several kinds or not at all.
function interpolated(shares) {
  let near = corners(shares).sort((a, b) => b[1] - a[1]).map(([node, weight]) => [grid.nodes[node], weight]);
  // Beside a node without an equilibrium nothing is known.
  if (near.some(([node]) => !node)) return null;
  const others = near[0][0].count - near[0][0].modes.filter(own => own).length;
  const mixed = parts => parts[0][0].map((_, i) => parts.reduce((sum, [part, weight]) => sum + weight * part[i], 0));
  const number = parts => mixed(parts.map(([x, w]) => [[x], w]))[0];
  // Of what swings or falls without friction the square of the rate changes steadily, through 0 as well.
  const square = own => own.kind === 'oscillation' && !own.growth ? own.omega ** 2 : own.kind === 'zero' ? 0 : own.kind === 'unstable' && !own.omega ? -(own.growth ** 2) : null;
  const rate = used => {
    if (used.every(([own]) => square(own) !== null)) {
      const all = number(used.map(([own, weight]) => [square(own), weight])), size = Math.sqrt(Math.abs(all));
      return all > 0 ? { kind: 'oscillation', omega: size, growth: 0 } : all < 0 ? { kind: 'unstable', omega: 0, growth: size } : { kind: 'zero', omega: 0, growth: 0 };
    }
    const part = name => number(used.map(([own, weight]) => [own[name], weight]));
    return { kind: used[0][0].kind, omega: part('omega'), growth: part('growth') };
  };
  const mode = k => {
    const all = near.map(([node, weight]) => [node.modes[k], weight]);
    const one = ([own]) => own && !own.imaginary && square(own) !== null;
    const alike = all.every(one) || all.every(([own]) => own && own.kind === all[0][0]?.kind && !own.imaginary === !all[0][0].imaginary);
    const used = alike ? all : [[all[0][0], 1]], first = used[0][0];
    if (!first) return null;
    const part = name => used.map(([own, weight]) => [own[name], weight]);
    return { ...rate(used), shape: mixed(part('shape')), imaginary: first.imaginary && mixed(part('imaginary')) };
  };
  const modes = data.modes.map((own, k) => {
    const found = mode(k) || { ...own, shape: own.shape.map(() => 0), imaginary: null, gone: true };
    const short = (x, unit) => x.toPrecision(3) + (data.units ? unit : ''), grows = found.growth !== 0;
    const told = found.gone ? 'nothing like it here' : found.kind === 'zero' ? 'zero mode' : found.kind === 'oscillation' ? `ω ≈ ${short(found.omega, ' rad/s')}`
      : `${found.kind}, ω ≈ ${short(found.omega, ' rad/s')}${grows ? `, growth ≈ ${short(found.growth, ' 1/s')}` : ''}`;
    return { ...found, caption: `${k + 1}: ${told}` + (others > 0 ? ` (${others} more here that the model's own values do not have)` : '') };
  });
  return { equilibrium: mixed(near.map(([node, weight]) => [node.equilibrium, weight])), modes };
}

// How far a mode has gone at a time in periods: the real and the imaginary part of its factor.
function factor(mode, t) {
  const turn = 2 * Math.PI * t;
  switch (mode.kind) {
    case 'zero': { const way = ((t / 2 + 0.5) % 1) * 2 - 1; return [way, 0]; }
    case 'overdamped': return [Math.exp(-3 * (t % 2)), 0];
    case 'unstable': case 'damped': {
      if (mode.omega === 0) return [0.05 * Math.exp(1.5 * (t % 2)), 0];
      // Three periods, then from the start.
      const own = t % 3, rate = Math.max(-1, Math.min(1, 2 * Math.PI * mode.growth / mode.omega));
      const size = mode.growth > 0 ? Math.exp(rate * (own - 3)) : Math.exp(rate * own);
      return [size * Math.cos(turn), size * Math.sin(turn)];
    }
    default: return [Math.cos(turn), Math.sin(turn)];
  }
}
function coordinates(mode, [re, im], far) {
  return shown.equilibrium.map((q, i) => q + far * (re * mode.shape[i] - im * (mode.imaginary ? mode.imaginary[i] : 0)));
}
function points(q) {
  const flat = figure.positions(q.concat(si)), all = [];
  for (let at = 0; at < flat.length; at += dimension) all.push(flat.slice(at, at + dimension));
  return all;
}
const distance = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
// The middle and half the width of everything, as far as it has been seen.
let view = null;
function look() {
  if (!figure) return;
  const all = points(shown.equilibrium).concat(figure.lines.some(line => line[1] === null) ? [Array(dimension).fill(0)] : []);
  const middle = view ? view.middle : [...Array(dimension).keys()].map(k => (Math.min(...all.map(p => p[k])) + Math.max(...all.map(p => p[k]))) / 2);
  const reach = middle.map((x, k) => Math.max(view ? view.reach[k] : 0, ...all.map(p => Math.abs(p[k] - x))));
  view = { middle, reach, half: Math.max(view ? view.half : 0, ...all.map(p => distance(p, middle))) || 1 };
}
look();
// The displacement that is well to be seen: angles stay below half a radian, points go a fifth of the width.
function choose() {
  const mode = shown.modes[number], parts = mode.shape.concat(mode.imaginary || []);
  const largest = Math.max(...parts.map(Math.abs)) || 1;
  scale = 1 / largest;
  moves = true;
  if (!figure) return;
  const rest = points(shown.equilibrium), small = 1e-4 * (data.angles ? 1 : view.half) / largest;
  const way = [[1, 0], [0, 1]].map(turn => {
    const there = points(coordinates(mode, turn, small));
    return Math.max(...there.map((p, i) => distance(p, rest[i]))) / small;
  });
  const far = Math.max(...way);
  moves = far * small > 1e-10 * view.half;
  if (moves) scale = Math.min(0.2 * view.half / far, data.angles ? 0.5 / largest : Infinity);
}
const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
function projected(p, width, height) {
  const own = p.map((x, i) => x - view.middle[i]);
  if (dimension === 2) {
    // With room for a fifth of the size on all sides.
    const unit = Math.min(...[width, height].map((room, k) => 0.45 * room / (view.reach[k] + 0.22 * view.half)));
    return [width / 2 + unit * own[0], height / 2 - unit * own[1], 0];
  }
  const unit = 0.36 * Math.min(width, height) / view.half;
  const [c, s] = [Math.cos(turned[0]), Math.sin(turned[0])], [d, e] = [Math.cos(turned[1]), Math.sin(turned[1])];
  const [x, y] = [c * own[0] - s * own[1], s * own[0] + c * own[1]], up = own[2] * d + y * e, deep = y * d - own[2] * e;
  return [width / 2 + unit * x, height / 2 - unit * up, deep / view.half];
}
function spring(a, b) {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]], long = Math.hypot(dx, dy) || 1, wide = 5;
  context.moveTo(a[0], a[1]);
  for (let k = 1; k < 12; k++) {
    const share = 0.15 + 0.7 * (k - 0.5) / 11, off = k % 2 ? wide : -wide;
    context.lineTo(a[0] + share * dx - off * dy / long, a[1] + share * dy + off * dx / long);
  }
  context.lineTo(b[0], b[1]);
}
function drawFigure(q, width, height) {
  const place = p => projected(p, width, height), origin = place(Array(dimension).fill(0));
  const rest = points(shown.equilibrium).map(place), now = points(q).map(place);
  const few = figure.lines.length <= 40;
  context.lineWidth = 2;
  for (const [a, b, kind] of figure.lines) {
    context.beginPath();
    const [from, to] = [now[a], b === null ? origin : now[b]];
    context.strokeStyle = colour(kind === 'rod' ? '--ink' : '--other');
    if (kind === 'spring' && few && dimension === 2) spring(from, to);
    else { context.moveTo(from[0], from[1]); context.lineTo(to[0], to[1]); }
    context.stroke();
  }
  if (figure.lines.some(line => line[1] === null)) {
    context.strokeStyle = colour('--ink');
    context.beginPath(); context.moveTo(origin[0] - 9, origin[1]); context.lineTo(origin[0] + 9, origin[1]); context.stroke();
  }
  context.strokeStyle = colour('--rest');
  for (const [x, y] of rest.slice(0, figure.dots)) { context.beginPath(); context.arc(x, y, 5, 0, 7); context.stroke(); }
  const order = now.slice(0, figure.dots).map((p, i) => i).sort((i, j) => now[j][2] - now[i][2]);
  const large = figure.dots <= 30 ? 7 : figure.dots <= 150 ? 4.5 : 2.5;
  for (const i of order) {
    const [x, y, deep] = now[i];
    context.fillStyle = colour('--mark');
    context.globalAlpha = dimension === 3 ? Math.max(0.45, Math.min(1, 0.75 - 0.3 * deep)) : 1;
    context.beginPath(); context.arc(x, y, large * (1 - 0.15 * deep), 0, 7); context.fill();
    context.globalAlpha = 1;
  }
}
// Where no points are known: each coordinate a bar.
function drawBars(mode, turn, far, width, height) {
  const n = mode.shape.length, unit = height / 2 - 30, parts = coordinates(mode, turn, 1).map((q, i) => q - shown.equilibrium[i]);
  const largest = Math.max(...mode.shape.concat(mode.imaginary || []).map(Math.abs)) || 1;
  const x = i => width * (i + 0.5) / n;
  context.strokeStyle = colour('--rest');
  context.beginPath(); context.moveTo(0, height / 2); context.lineTo(width, height / 2); context.stroke();
  context.strokeStyle = context.fillStyle = colour('--mark');
  context.lineWidth = Math.max(1, Math.min(6, 0.3 * width / n));
  const step = Math.ceil(70 * n / width);
  context.font = '13px sans-serif'; context.textAlign = 'center';
  parts.forEach((part, i) => {
    const y = height / 2 - unit * far * part / largest;
    context.fillStyle = colour('--mark');
    context.beginPath(); context.moveTo(x(i), height / 2); context.lineTo(x(i), y); context.stroke();
    context.beginPath(); context.arc(x(i), y, Math.max(2, Math.min(7, 0.3 * width / n)), 0, 7); context.fill();
    context.fillStyle = colour('--ink');
    const half = context.measureText(data.names[i]).width / 2 + 2;
    if (i % step === 0) context.fillText(data.names[i], Math.max(half, Math.min(width - half, x(i))), height - 8);
  });
}
function draw() {
  const mode = shown.modes[number], ratio = devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio);
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const turn = factor(mode, time), far = parseFloat(size.value);
  if (missing) return;
  if (figure && moves) {
    const q = coordinates(mode, turn, far * scale);
    drawFigure(q, width, height);
    // Where it stands still, for those who check it.
    if (!running) canvas.dataset.drawn = JSON.stringify({ coordinates: q, points: points(q) });
  } else drawBars(mode, turn, far, width, height);
}
function tick(now) {
  if (running) time += Math.min(0.1, (now - last) / 1000) * parseFloat(speed.value) / 2;
  last = now;
  draw();
  if (running) requestAnimationFrame(tick);
}
function go() { last = performance.now(); requestAnimationFrame(tick); pause.textContent = running ? 'Pause' : 'Play'; }
function select(at, restart) {
  number = at;
  rows.forEach((row, i) => { if (i === at) row.setAttribute('aria-current', 'true'); else row.removeAttribute('aria-current'); });
  choose();
  caption.textContent = missing ? 'No equilibrium or no modes are known here.' : shown.modes[at].caption + (figure && !moves ? ' (no drawn point moves: the coordinates are shown)' : '');
  canvas.setAttribute('aria-label', 'Moving picture of mode ' + shown.modes[at].caption);
  if (restart) time = 0;
  if (!running) draw();
}
const columns = [...document.querySelectorAll('thead th')].map(head => head.textContent.split(' ')[0]);
const cells = rows.map(row => [...row.children].slice(1).map((cell, i) => [cell, cell.textContent, columns[i + 1]]));
// Moves to the sliders, or back to what the model says.
function move(back) {
  const shares = axes.map((axis, k) => { if (back) sliders[k].value = axis.own ?? 0.5; return parseFloat(sliders[k].value); });
  axes.forEach((axis, k) => { sliders[k].nextElementSibling.textContent = parseFloat(between(...axis.ends, shares[k]).toPrecision(4)); });
  si = axes.map((axis, k) => between(...axis.si, shares[k]));
  const found = back ? data : interpolated(shares);
  byId('own').disabled = back;
  missing = !found;
  shown = found || shown;
  cells.forEach((row, k) => row.forEach(([cell, text]) => { cell.textContent = text; }));
  if (!back) cells.forEach((row, k) => {
    const { kind, omega, growth, gone } = missing ? { kind: '', omega: 0, growth: 0, gone: true } : shown.modes[k], texts = { kind, 'ω': omega, growth };
    row.forEach(([cell, , column]) => {
      const text = texts[column];
      if (['bound', 'f', 'motion'].includes(column)) cell.textContent = '';
      else if (text !== undefined) cell.textContent = gone ? '' : typeof text === 'string' ? text : text === 0 ? '0' : '≈ ' + text.toPrecision(3);
    });
  });
  look();
  select(number, false);
}
if (grid) {
  sliders.forEach(slider => slider.addEventListener('input', () => move(false)));
  byId('own').addEventListener('click', () => move(true));
}
rows.forEach((row, at) => row.addEventListener('click', () => select(at, true)));
pause.addEventListener('click', () => { running = !running; go(); });
size.addEventListener('input', draw);
addEventListener('resize', draw);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
let held = null;
canvas.addEventListener('pointerdown', event => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
canvas.addEventListener('pointerup', () => { held = null; });
canvas.addEventListener('pointermove', event => {
  if (!held || dimension !== 3) return;
  turned = [turned[0] + (event.clientX - held[0]) / 150, turned[1] + (event.clientY - held[1]) / 150];
  held = [event.clientX, event.clientY];
  if (!running) draw();
});
canvas.addEventListener('keydown', event => {
  const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
  if (turns && dimension === 3) { turned = turned.map((angle, i) => angle + turns[i]); draw(); event.preventDefault(); }
  if (event.key === ' ') { pause.click(); event.preventDefault(); }
});
document.body.classList.add('live');
if (axes.some(axis => asked.has(axis.name))) {
  axes.forEach((axis, k) => { if (asked.has(axis.name)) sliders[k].value = (parseFloat(asked.get(axis.name)) - axis.ends[0]) / (axis.ends[1] - axis.ends[0]); });
  move(false);
}
select(number, false);
draw();
go();
})();
