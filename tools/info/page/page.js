// The page: reads what vc-info stored, paints the object, and tells of the line under the cursor.
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);
const find = id => document.getElementById(id);
const css = rgb => `rgb(${rgb.map(Math.round).join(', ')})`;
const nameOf = object => object.name || '(no name)';
const percent = share => `${(100 * share).toFixed(share > 0 && share < 0.1 ? 1 : 0)}\u00a0%`;
const counted = (count, thing) => `${count.toLocaleString('en')} ${thing}${count === 1 ? '' : 's'}`;
const mix = (a, b, share) => a.map((x, k) => x + (b[k] - x) * share);

const CLASSES = [['clear', 'Clear'], ['blocked', 'Blocked, proven'], ['unclassified', 'Unclassified'],
                 ['statistical', 'Blocked, by statistics']].map(([id, name], i) =>
                     ({id, name, colour: data.class_colours[i]}));
const [CLEAR, BLOCKED, UNCLASSIFIED, STATISTICAL] = CLASSES;
const MEANINGS = {
  clear: 'No triangle meets any line of the cell.',
  blocked: 'Every line of the cell is blocked.',
  unclassified: 'The look-up says nothing: the hierarchy or the BVH decides.',
  statistical: 'Every sample line of the cell was blocked, which proves nothing.',
};
const NONE = [176, 180, 186], ANSWERED = [208, 212, 217];
const SCALE = [[224, 122, 31], [240, 214, 168], [120, 160, 200], [33, 76, 133]];
const HORIZON_SCALE = [[72, 52, 96], [130, 110, 160], [226, 196, 140], [250, 238, 190]];
const WHYS = [
  {name: 'Silhouette', colour: [42, 157, 143],
   says: 'the cell has clear and blocked lines, and on straight ways through it they change at most once'},
  {name: 'Foliage', colour: [124, 179, 66],
   says: 'on straight ways through the cell they change more often: parts or gaps are thinner than it is wide'},
  {name: 'Boundary', colour: [214, 69, 107],
   says: 'its lines look blocked, and the sheet that blocks them ends in the cell, at a boundary or non-manifold edge'},
  {name: 'Unproven', colour: [142, 107, 191],
   says: 'its lines look blocked to 16 rays, and no one sheet is proven to block them all'},
  {name: 'Known', colour: [228, 186, 40],
   says: 'a proof succeeds: the bake tried none, or gave the class up, or never asked, to save bytes'},
];

function along(scale, share) {
  const at = Math.min(Math.max(share, 0), 1) * (scale.length - 1), below = Math.min(Math.floor(at), scale.length - 2);
  return mix(scale[below], scale[below + 1], at - below);
}
function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
function chip(colour) { return element('span', '', {class: 'chip', style: `background: ${css(colour)}`}); }
function keyed(tag, colour, text) {
  const made = element(tag);
  made.append(chip(colour), text);
  return made;
}

// What the page's arrays say of one object.
class Shown {
  constructor(object, arrays) {
    const bytes = ([first, size]) => new Uint8Array(arrays, first, size);
    Object.assign(this, {
      object, positions: new Float32Array(arrays, object.positions[0], object.positions[1] / 4),
      indices: new Uint32Array(arrays, object.indices[0], object.indices[1] / 4),
      answered: bytes(object.answered), proven: bytes(object.proven), whys: object.why.map(bytes),
      horizons: object.horizons && bytes(object.horizons), tree: object.tree && bytes(object.tree.place),
    });
  }
  reason(t) {  // the most frequent one; -1: none
    const shares = this.whys.map(why => why[t]), most = Math.max(...shares);
    return most > 0 ? shares.indexOf(most) : -1;
  }
  classOf(line) {
    if (!this.tree) return null;
    const found = CLASSES[classOf(this.object, this.tree, line)];
    if (found === STATISTICAL && this.object.method !== 'hybrid') return UNCLASSIFIED;  // no reader believes it
    return found === BLOCKED && this.object.method === 'sampled' ? STATISTICAL : found;
  }
}

const scaleLegend = (title, scale, low, high) => {
  const row = element('div', undefined, {class: 'scale'});
  row.append(low, element('span', '', {style: `background: linear-gradient(to right, ${scale.map(css)})`}), high);
  return [element('b', title), row];
};
const MODES = [
  {id: 'answered', name: 'Answered', exists: () => true,
   colour: (shown, t) => along(SCALE, shown.answered[t] / 255),
   legend: () => scaleLegend('Lines through a place that look-ups answer', SCALE, 'none', 'all'),
   says: () => [['Answered', 'Of the lines through each place of the surface, in 48 directions, the share whose cell is '
                + 'blocked, by proof or by statistics. So many of the shadow rays that pass the box here need no BVH.']]},
  {id: 'why', name: 'Why not', exists: () => true,
   colour: (shown, t) => {
     const reason = shown.reason(t);
     return reason < 0 ? ANSWERED : mix(WHYS[reason].colour, ANSWERED, 0.8 * shown.answered[t] / 255);
   },
   legend: shown => {
     const list = element('ul', undefined, {class: 'key'});
     WHYS.forEach((why, i) => { if (shown.whys[i].some(x => x)) list.append(keyed('li', why.colour, why.name)); });
     list.append(keyed('li', ANSWERED, 'answered'));
     return [element('b', 'Why lines through a place are unclassified'), list];
   },
   says: () => WHYS.map(why => [why.name, why.says[0].toUpperCase() + why.says.slice(1) + '.'])},
  {id: 'horizons', name: 'Horizon', exists: shown => shown.horizons,
   colour: (shown, t) => shown.horizons[t] === 255 ? NONE : along(HORIZON_SCALE, shown.horizons[t] / 254),
   legend: () => scaleLegend('Directions above a triangle proven clear', HORIZON_SCALE, 'none',
                             'all'),
   says: () => [['Horizon', 'Of the directions above each triangle, the share in which a ray that starts there is '
                + 'proven clear. Grey: the triangle has no horizon.']]},
];

class Page {
  constructor(arrays) {
    this.all = data.objects.map(object => new Shown(object, arrays));
    try {
      this.view = new View3D(find('view'));
    } catch (error) {  // without WebGL: all but the object itself
      this.view = new Proxy({}, {get: () => () => {}});
      find('hint').textContent = `This browser cannot draw the object: ${error.message}`;
    }
    this.mode = MODES[0];
    this.kept = false;
    const choice = find('object');
    data.objects.forEach((o, i) => choice.append(element('option', `${o.source_index} ${nameOf(o)}`, {value: i})));
    choice.hidden = data.objects.length < 2;
    choice.addEventListener('change', () => this.show(Number(choice.value)));
    this.up = 'y';
    find('up').addEventListener('click', () => this.stand(this.up === 'y' ? 'z' : 'y'));
    this.listen(find('view'));
    this.show(0);
  }

  show(number) {
    this.shown = this.all[number];
    const o = this.shown.object;
    this.view.show(o, this.shown.positions, this.shown.indices);
    this.stand(this.up);
    const drawn = o.thinned ? `thinned to ${o.drawn.toLocaleString('en')} for this page`
        : o.drawn > o.triangles ? 'cut finer for the colours' : 'all drawn';
    find('summary').textContent = `${nameOf(o)}: ${counted(o.triangles, 'triangle')}, ${drawn}, from `
        + `${o.mesh_source}.` + (o.method === 'none' ? '' : ` Baked ${o.method}, depth ${o.depth}.`);
    this.tellFacts(o);
    this.showViews(o);
    if (!this.mode.exists(this.shown)) this.mode = MODES[0];
    this.showModes();
    this.kept = false;
    this.tell(null);
  }

  stand(up) {
    this.up = up;
    find('up').textContent = `${up} is up`;
    this.view.stand(up);
  }

  showModes() {
    const modes = MODES.filter(mode => mode.exists(this.shown));
    find('modes').replaceChildren(...modes.map(mode => {
      const button = element('button', mode.name, {'data-mode': mode.id, 'aria-pressed': mode === this.mode});
      button.addEventListener('click', () => { this.mode = mode; this.showModes(); });
      return button;
    }));
    find('legend').replaceChildren(...this.mode.legend(this.shown));
    const list = element('dl');
    for (const [term, text] of modes.flatMap(mode => mode.says())) list.append(element('dt', term), element('dd', text));
    find('explained').replaceChildren(list);
    this.view.paint(t => this.mode.colour(this.shown, t).map(x => x / 255));
  }

  tellFacts(object) {
    const rows = [];
    for (const line of object.facts.split('\n').filter(Boolean)) {
      const term = line.slice(2, 12).trim(), text = line.slice(12);
      if (term) rows.push([term, text]);
      else rows[rows.length - 1][1] += '\n' + text;
    }
    const list = pairs => pairs.flatMap(([term, text]) => [element('dt', term), element('dd', text)]);
    find('facts').replaceChildren(...list(rows));
    find('provenance').replaceChildren(...list(Object.entries(data.provenance)));
  }

  showViews(object) {
    find('views').replaceChildren(...object.views.map(view => {
      const figure = element('figure'), where = `azimuth ${view.azimuth}°, elevation ${view.elevation}°`;
      const shares = [0, 1, 3, 2].filter(i => view.shares[i] >= 0.0005)
          .map(i => `${CLASSES[i].id} ${percent(view.shares[i])}`).join(', ');
      const caption = element('figcaption', where);
      caption.append(element('br'), shares);
      figure.append(element('img', undefined, {src: view.png, alt: `Classes from ${where}: ${shares}`}), caption);
      return figure;
    }));
    if (object.views.length === 0) find('views').append(element('p', 'Only the first 32 objects have pictures.', {class: 'note'}));
  }

  // A mouse tells as it moves; a click or a tap keeps the line, another lets it go.
  listen(canvas) {
    let down = null, asked = null;
    canvas.addEventListener('pointerdown', e => { down = e.isPrimary ? [e.clientX, e.clientY] : null; });
    canvas.addEventListener('pointerup', e => {
      const still = down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) < 6;
      down = null;
      if (!still) return;
      const line = this.view.lineAt(e.clientX, e.clientY);
      this.kept = cellOfLine(this.shown.object, line.point, line.direction) !== null;
      this.tell(line);
    });
    canvas.addEventListener('pointermove', e => {
      if (e.pointerType !== 'mouse' || e.buttons || this.kept) return;
      if (!asked) requestAnimationFrame(() => {
        if (!this.kept) this.tell(this.view.lineAt(...asked));
        asked = null;
      });
      asked = [e.clientX, e.clientY];
    });
    canvas.addEventListener('pointerleave', () => { if (!this.kept) this.tell(null); });
  }

  tell(line) {
    const o = this.shown.object, cell = line && cellOfLine(o, line.point, line.direction);
    const head = element('h2', this.kept ? 'The line that is kept' : 'The line under the cursor');
    if (this.kept) {
      const release = element('button', 'let go');
      release.addEventListener('click', () => { this.kept = false; this.tell(null); });
      head.append(release);
    }
    if (!cell) {
      this.view.showCell(null);
      find('reading').replaceChildren(head, element('p', line ? 'It misses the box: clear.'
          : 'Point at the object, or tap it, to see the cell of that line, its class, and what is known of the place '
          + 'that it meets.', {class: 'note'}));
      return;
    }
    const found = this.shown.classOf(cell.line);
    this.view.showCell(cell, css(found ? found === BLOCKED ? [90, 98, 116] : found.colour : NONE));
    const [low, high] = cell.faces.map(face => FACES[face]), [s, t, u, v] = cell.at;
    const parts = [head];
    if (found) {
      const name = keyed('p', found.colour, found.name);
      name.className = 'class';
      parts.push(name, element('p', MEANINGS[found.id], {class: 'note'}));
    } else {
      parts.push(element('p', o.method === 'none' ? 'Baked without look-ups: all lines are unclassified.'
          : 'The tree is too large for this page: there is no look-up here.'));
    }
    parts.push(element('p', `Cell: ${low} (${s}, ${t}) to ${high} (${u}, ${v}), of ${2 ** o.depth} × ${2 ** o.depth} `
        + `squares a face. The line meets ${counted(line.met, 'triangle')} as drawn.`, {id: 'cell'}));
    if (line.triangle >= 0) parts.push(...this.ofPlace(line.triangle));
    find('reading').replaceChildren(...parts);
  }

  ofPlace(t) {
    const {answered, proven, whys, horizons} = this.shown;
    const bar = shares => {
      const made = element('div', '', {class: 'bar'});
      for (const [colour, share] of shares)
        if (share > 0) made.append(element('span', '', {style: `width: ${100 * share}%; background: ${css(colour)}`}));
      return made;
    };
    const all = answered[t] / 255, proof = proven[t] / 255;
    const parts = [bar([[BLOCKED.colour, proof], [STATISTICAL.colour, all - proof], [UNCLASSIFIED.colour, 1 - all]]),
                   element('p', `Lines through this place: ${percent(proof)} proven, ${percent(all - proof)} by `
                           + `statistics, ${percent(1 - all)} unclassified.`)];
    const reasons = WHYS.map((why, i) => ({...why, share: whys[i][t] / 255})).filter(why => why.share > 0);
    if (reasons.length) {
      const list = element('ul', undefined, {class: 'key'});
      for (const why of reasons.sort((a, b) => b.share - a.share))
        list.append(keyed('li', why.colour, `${why.name} ${percent(why.share)}`));
      parts.push(element('p', 'Why not:'), list);
    }
    if (horizons && horizons[t] < 255)
      parts.push(element('p', `Its horizon: ${percent(horizons[t] / 254)} of the directions above it are proven clear.`));
    return parts;
  }
}

async function start() {
  const packed = Uint8Array.from(atob(find('arrays').textContent), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const arrays = await new Response(stream).arrayBuffer();
  find('classes').append(...[CLEAR, BLOCKED, STATISTICAL, UNCLASSIFIED].map(c => keyed('li', c.colour, c.name)));
  find('made').textContent = `${data.file}, ${data.bytes.toLocaleString('en')} bytes. Made by vc-info ${data.version}.`;
  window.page = new Page(arrays);
}
start().catch(error => {
  find('reading').textContent = `This browser cannot draw the object: ${error.message}`;
  console.error(error);
});
