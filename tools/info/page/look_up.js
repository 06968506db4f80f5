// Line → cell → class, as spec/vcd-format.md says: "Line to cell" and "TREE section".
'use strict';

const FACES = ['x min', 'x max', 'y min', 'y max', 'z min', 'z max'];
const PAIRS = [];
for (let low = 0; low < 6; ++low) for (let high = low + 1; high < 6; ++high) PAIRS.push([low, high]);
const AXES_OF = [[1, 2], [0, 2], [0, 1]];  // the two axes of a face, by its normal's axis

// {pair, cell: [s, t, u, v], entry, exit} of the line origin + t direction, cells of level 8; null if it misses the
// box. The origin has to be near the box; entry and exit are values of t.
function locate(object, origin, direction) {
  const f = Math.fround, p = [], q = [], near = [], far = [];
  for (let a = 0; a < 3; ++a) {
    const low = f(object.box_min[a]), scale = f(256 / f(f(object.box_max[a]) - low));
    p[a] = f(f(f(origin[a]) - low) * scale);
    q[a] = f(f(direction[a]) * scale);
    const size = Math.max(Math.abs(q[a]), 2 ** -100);
    q[a] = q[a] < 0 || Object.is(q[a], -0) ? -size : size;
    const r = f(1 / q[a]), atLow = f(f(0 - p[a]) * r), atHigh = f(f(256 - p[a]) * r);
    near[a] = Math.min(atLow, atHigh);
    far[a] = Math.max(atLow, atHigh);
  }
  const entry = Math.max(...near), exit = Math.min(...far);
  if (!(entry < exit)) return null;
  const into = near.indexOf(entry), out = far.indexOf(exit);
  const entryFace = 2 * into + (q[into] < 0 ? 1 : 0), exitFace = 2 * out + (q[out] < 0 ? 0 : 1);
  const at = t => p.map((x, a) => Math.floor(Math.min(Math.max(f(f(q[a] * t) + x), 0), 255)));
  const swapped = entryFace > exitFace;
  const [low, high] = swapped ? [exitFace, entryFace] : [entryFace, exitFace];
  const [first, second] = swapped ? [at(exit), at(entry)] : [at(entry), at(exit)];
  const on = (face, point) => AXES_OF[face >> 1].map(axis => point[axis]);
  return {pair: PAIRS.findIndex(([a, b]) => a === low && b === high), cell: [...on(low, first), ...on(high, second)],
          entry, exit};
}

// The number of a class: 0 clear, 1 blocked, 2 unclassified, 3 statistically blocked. tree: the section's bytes.
function classOf(object, tree, line) {
  const index = (bits, k) => line.cell.reduce((sum, x) => (sum << bits) | ((x >> k) & ((1 << bits) - 1)), 0);
  const word = at => new DataView(tree.buffer, tree.byteOffset + at, 4).getUint32(0, true);
  let number = line.pair, k = 8;
  for (const [at, bits] of object.tree.tables) number = word(at + 4 * (number * 16 ** bits + index(bits, k -= bits)));
  const cell = index(2, k - 2);
  return (tree[object.tree.bricks + 64 * number + (cell >> 2)] >> (2 * (cell & 3))) & 3;
}

// The line through a point, as {origin, direction}: t from 0 to 1 is from one length of its way through the box before
// the box to one behind it. null where it misses the box.
function throughBox(object, point, direction) {
  let entry = -Infinity, exit = Infinity;
  for (let a = 0; a < 3; ++a) {
    const at = [object.box_min[a], object.box_max[a]].map(side => (side - point[a]) / direction[a]);
    if (Number.isNaN(at[0]) || Number.isNaN(at[1])) continue;
    entry = Math.max(entry, Math.min(...at));
    exit = Math.min(exit, Math.max(...at));
  }
  if (!(entry < exit)) return null;
  return {origin: point.map((x, a) => x + (2 * entry - exit) * direction[a]),
          direction: direction.map(x => 3 * (exit - entry) * x)};
}

// What the page shows of a line: its faces, the coordinates of its cell, the cell's two squares and where the line
// enters and leaves the box, in the object's frame. null where it misses the box.
function cellOfLine(object, point, direction) {
  const ray = throughBox(object, point, direction), line = ray && locate(object, ray.origin, ray.direction);
  if (!line) return null;
  const faces = PAIRS[line.pair], shift = 8 - object.depth;
  const at = line.cell.map(x => x >> shift);
  const squares = faces.map((face, i) => {
    const [first, second] = AXES_OF[face >> 1];
    return [[0, 0], [1, 0], [1, 1], [0, 1]].map(([x, y]) => {
      const grid = [];
      grid[face >> 1] = face % 2 ? 256 : 0;
      grid[first] = (at[2 * i] + x) << shift;
      grid[second] = (at[2 * i + 1] + y) << shift;
      return grid.map((g, a) => object.box_min[a] + g / 256 * (object.box_max[a] - object.box_min[a]));
    });
  });
  const ends = [line.entry, line.exit].map(t => ray.origin.map((x, a) => x + t * ray.direction[a]));
  return {line, faces, at, squares, ends};
}
