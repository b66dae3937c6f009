// Puts the page together from the results.

const results = JSON.parse(document.getElementById('results').textContent);
const engines = results.engines.map((engine) => engine.name);

const verdictMarks = {on_front: '✓ on the front', beaten: '✗ beaten', alone: '– alone', no_standing: '! no standing',
  not_judged: '– not judged'};

function verdictElement(verdict, tag) {
  return html(tag, {class: 'verdict ' + verdict.kind},
    html('span', {class: 'mark'}, verdictMarks[verdict.kind] + '. '), verdict.text);
}

function writeFacts() {
  const machine = results.machine;
  const facts = [['CPU', `${machine.cpu}, ${machine.cores} cores`], ['System', machine.system],
    ['Compiler', machine.compiler], ['Date', results.date],
    ...results.engines.map((e) => [e.name, e.version + (e.precision ? ', ' + e.precision : '')]),
    ['Runs', `${results.quick ? 'quick, ' : ''}each timed ${results.repeats === 1 ? 'once' : results.repeats + ' times'},` +
      ` ${figure(results.min_time_s)} s or longer` +
      (results.interrupted ? ', and interrupted before all were done' : '')]];
  for (const [name, value] of facts) {
    document.getElementById('facts').append(html('div', {}, html('dt', {}, name), html('dd', {}, value)));
  }
}

/** In how many scenes the default of Atoll stands how. */
function tallyText() {
  const kinds = results.scenes.map((scene) => scene.comparisons[0]?.verdict.kind);
  const count = (kind) => kinds.filter((k) => k === kind).length;
  const words = {on_front: 'on the front', beaten: 'beaten', alone: 'without another engine to compare with',
    no_standing: 'without a standing of its own', not_judged: 'not judged'};
  const parts = Object.keys(words).filter(count).map((kind) => `${words[kind]} in ${count(kind)}`);
  const scenes = results.scenes.length;
  return `Of ${scenes} ${scenes === 1 ? 'scene' : 'scenes'}, the default of Atoll is ${parts.join(', ')}.`;
}

/** A scene's address, which a line may end in after each parameter. */
function sceneName(scene) {
  return scene.name.split(/(?<=[:,])/).flatMap((part, i) => (i ? [html('wbr'), part] : [part]));
}

function writeOverview() {
  if (!results.scenes.length) {
    for (const id of ['standing', 'reading']) document.getElementById(id).hidden = true;
    return;
  }
  document.getElementById('tally').textContent = tallyText();
  const body = document.querySelector('#overview tbody');
  results.scenes.forEach((scene, index) => {
    const own = scene.runs[0], first = scene.comparisons[0];
    const error = first && own.errors[first.measure];
    const time = own.cpu_s_per_simulated_s;
    body.append(html('tr', {},
      html('td', {}, html('a', {href: '#scene-' + index}, ...sceneName(scene))),
      html('td', {'data-name': 'error'}, error === undefined || own.outcome !== 'done' ? outcomeWords[own.outcome] :
        errorText(Math.abs(error), first.unit, results.no_error) + ' ' + first.measure),
      html('td', {'data-name': 'CPU time per simulated s'}, time ? duration(time.median) : ''),
      first ? html('td', {class: first.verdict.kind},
        html('span', {class: 'mark'}, verdictMarks[first.verdict.kind] + '. '),
        html('span', {class: 'words'}, first.verdict.text)) : html('td')));
  });
}

function sceneWords(scene) {
  const steps = scene.steps === scene.scene_steps ? `${scene.steps} steps` :
    `${scene.steps} of the scene's ${scene.scene_steps} steps`;
  const words = [html('p', {}, (scene.help ? scene.help[0].toUpperCase() + scene.help.slice(1) + '. ' : '') +
    `${scene.bodies} dynamic bodies, ${steps}, ${figure(scene.simulated_s)} s of simulated time` +
    (scene.large ? '; a large scene, on a thinner grid of settings.' : '.'))];
  if (scene.view) {
    words.push(html('p', {class: 'note'}, html('a', {href: scene.view}, 'Watch it'), ' by its own settings.'));
  }
  if (scene.source) words.push(html('p', {class: 'note'}, 'Closed form: ' + scene.source));
  if (scene.chaotic) {
    words.push(html('p', {class: 'note'}, 'Chaotic: no two engines, nor two settings, end in the same state, so only ' +
      'statistics of the final state compare.'));
  }
  return words;
}

/** Engines that gave nothing to draw, and why. */
function absentWords(scene) {
  const byReason = new Map();
  for (const run of scene.runs) {
    if (!['refused', 'too_slow', 'skipped', 'failed'].includes(run.outcome)) continue;
    const reason = run.engine + '\n' + run.why;
    byReason.set(reason, [...byReason.get(reason) || [], run]);
  }
  if (!byReason.size) return '';
  return html('ul', {class: 'note'}, ...[...byReason.values()].map((runs) => {
    const labels = runs[0].outcome === 'refused' ? '' : ` (${runs.map((run) => run.label).join('; ')})`;
    return html('li', {}, runs[0].engine + labels + ': ' + runs[0].why);
  }));
}

function legend(scene) {
  const present = engines.filter((name) => scene.runs.some((run) => run.engine === name));
  const item = (picture, text) => html('li', {}, svg('svg', {width: 22, height: 14, viewBox: '-11 -7 22 14',
    'aria-hidden': 'true'}, picture), text);
  const list = present.map((name) => item(marker(engines.indexOf(name), 5), name));
  list.push(item(svg('path', {d: 'M-11 0H11', class: 'front atoll'}), 'front of Atoll'));
  if (present.length > 1) list.push(item(svg('path', {d: 'M-11 0H11', class: 'front peers'}), 'front of the others'));
  list.push(item(svg('circle', {r: 5.5, class: 'ring', stroke: 'var(--soft-ink)'}), 'ringed: a default'));
  if (scene.runs.some(hasTarget)) {
    list.push(item(svg('g', {}, marker(0, 5), targetHole(5)), 'with a hole: substeps by an error target'));
  }
  const hollow = (extra) => svg('g', {class: 'point hollow'}, svg('path', {d: markerPath(0, 5), style: grey}), extra);
  const grey = 'stroke: var(--soft-ink)';
  const some = (outcome) => scene.runs.some((run) => run.outcome === outcome);
  if (some('fell')) list.push(item(hollow(''), 'fell'));
  if (some('came_apart')) list.push(item(hollow(''), 'came apart'));
  if (some('non_finite')) {
    list.push(item(hollow(svg('path', {d: 'M-2.5 -2.5L2.5 2.5M-2.5 2.5L2.5 -2.5', style: grey})), 'became non-finite'));
  }
  return html('ul', {class: 'legend'}, ...list);
}

function tipContent(r, comparison) {
  const [name, ...lines] = runWords(r, comparison, results.no_error);
  return [html('strong', {}, name), ...lines.map((line) => html('div', {}, line))];
}

/** The runs on the fronts by name, from the fastest to the most exact. */
function frontWords(scene, comparison) {
  const side = (title, places, name) => {
    const names = places.map((index) => name(scene.runs[index]));
    return names.length ? [html('p', {class: 'note'}, html('strong', {}, title), names.join('; ') + '.')] : [];
  };
  return [...side('Front of Atoll, from the fastest on: ', comparison.atoll_front, (run) => run.label),
    ...side('Of the others: ', comparison.peer_front, (run) => `${run.engine}, ${run.label}`)];
}

/** A diagram that answers to the pointer, to taps and to the arrow keys. */
class Plot {
  constructor(scene) {
    this.scene = scene;
    this.tip = html('div', {class: 'tip', role: 'status'});
    this.tip.hidden = true;
    this.holder = html('div', {class: 'plot'}, this.tip);
    this.current = -1;
  }

  show(comparison) {
    this.comparison = comparison;
    this.width = this.holder.clientWidth;
    this.runs = drawPlot(this.holder, this.scene, comparison, engines, results.no_error);
    this.drawing = this.holder.querySelector('svg');
    this.drawing.addEventListener('pointermove', (event) => this.point(event));
    this.drawing.addEventListener('pointerdown', (event) => this.point(event));
    // A finger that is lifted leaves too, and what it tapped has to stay.
    this.drawing.addEventListener('pointerleave', (event) => event.pointerType === 'touch' || this.select(-1));
    this.drawing.addEventListener('blur', () => this.select(-1));
    this.drawing.addEventListener('keydown', (event) => this.key(event));
    this.select(-1);
  }

  resize() {
    if (this.comparison && this.holder.clientWidth !== this.width) this.show(this.comparison);
  }

  point(event) {
    const bounds = this.drawing.getBoundingClientRect();
    const x = event.clientX - bounds.left, y = event.clientY - bounds.top;
    let nearest = -1, min = 26;
    this.runs.forEach((r, index) => {
      const distance = Math.hypot(r.x - x, r.y - y);
      if (distance < min) [nearest, min] = [index, distance];
    });
    this.select(nearest);
  }

  key(event) {
    const moves = {ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1};
    if (event.key === 'Escape') this.select(-1);
    if (!(event.key in moves) || !this.runs.length) return;
    event.preventDefault();
    const count = this.runs.length;
    this.select(this.current < 0 ? 0 : (this.current + moves[event.key] + count) % count);
  }

  select(index) {
    this.current = index;
    const cursor = this.drawing.querySelector('.cursor');
    cursor.setAttribute('visibility', index < 0 ? 'hidden' : 'visible');
    this.tip.hidden = index < 0;
    if (index < 0) return;
    const r = this.runs[index];
    cursor.setAttribute('transform', `translate(${r.x} ${r.y})`);
    this.tip.replaceChildren(...tipContent(r, this.comparison));
    const left = Math.min(Math.max(0, r.x + 16), this.holder.clientWidth - this.tip.offsetWidth);
    const below = r.y + 16 + this.tip.offsetHeight < this.holder.clientHeight;
    this.tip.style.left = left + 'px';
    this.tip.style.top = (below ? r.y + 16 : r.y - 16 - this.tip.offsetHeight) + 'px';
  }
}

function sceneSection(scene, index) {
  const section = html('section', {class: 'scene', id: 'scene-' + index, 'aria-labelledby': `scene-${index}-title`},
    html('h2', {id: `scene-${index}-title`}, ...sceneName(scene)), ...sceneWords(scene));
  document.getElementById('scenes').append(section);
  if (!scene.comparisons.length) {
    section.append(html('p', {}, 'No run got far enough to have an error.'), absentWords(scene));
    return;
  }

  const plot = new Plot(scene);
  const chosen = html('select', {id: 'measure-' + index}, ...scene.comparisons.map((comparison, place) =>
    html('option', {value: place}, comparison.measure)));
  const verdict = html('div', {'aria-live': 'polite'}), help = html('p', {class: 'note'}), fronts = html('div');
  const table = html('div', {class: 'scroll'});
  section.append(verdict,
    html('div', {class: 'controls'}, html('label', {for: chosen.id}, 'Error by ', chosen), legend(scene)),
    help, plot.holder, fronts, absentWords(scene),
    html('details', {}, html('summary', {}, 'All runs, by error'), table), sameBitsTable(scene));

  const show = () => {
    const comparison = scene.comparisons[chosen.value];
    verdict.replaceChildren(verdictElement(comparison.verdict, 'p'));
    help.textContent = comparison.measure + ': ' + comparison.help + (comparison.unit ? ` (${comparison.unit})` : '');
    plot.show(comparison);
    fronts.replaceChildren(...frontWords(scene, comparison));
    table.replaceChildren(runsTable(scene, comparison, results.no_error));
  };
  chosen.addEventListener('change', show);
  show();
  // Drawn anew in a frame of its own, since a new height would make the observer call again at once.
  new ResizeObserver(() => requestAnimationFrame(() => plot.resize())).observe(plot.holder);
}

writeFacts();
writeOverview();
writeFrontiers(results.frontiers);
results.scenes.forEach(sceneSection);
