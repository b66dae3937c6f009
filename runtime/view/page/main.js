// The page: reads the film that stands in it, and plays it.

import { Film, Flag } from './film.js';
import { colourings } from './colours.js';
import { Stage } from './stage.js';
import { Strip } from './strip.js';

const byId = (id) => document.getElementById(id);
const film = new Film(JSON.parse(byId('film').textContent));

function element(name, text, attributes = {}) {
  const made = document.createElement(name);
  made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

const fixed = (value, digits = 4) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
const vector = (values, digits) => values.map((value) => fixed(value, digits)).join(', ');
const plural = (count, word) => `${count} ${count === 1 ? word : word.endsWith('y') ? word.slice(0, -1) + 'ies' : `${word}s`}`;

class Player {
  constructor() {
    this.current = 0;
    this.playing = false;
    this.stage = new Stage(byId('stage'), film);
    this.strip = new Strip(byId('strip'), film, (frame) => this.seek(frame));
    this.asked = 0;
  }

  async start() {
    this.tellFacts();
    this.connect();
    await this.stage.build(await film.loadFrame(0));
    const wanted = new URLSearchParams(location.hash.slice(1) || film.data.place);
    const frame = wanted.has('step') ? film.frameOf(Number(wanted.get('step'))) : 0;
    if (colourings[wanted.get('colour')]) byId('colour').value = wanted.get('colour');
    for (const look of ['contacts', 'joints', 'boxes']) byId(look).checked = wanted.has(look);
    this.applyLooks();
    this.stage.resize();
    this.stage.frameAll(await film.loadFrame(frame));
    if (wanted.has('body')) this.stage.selected = film.bodies.findIndex((body) => String(body.id[0]) === wanted.get('body'));
    if (this.stage.selected === -1) this.stage.selected = null;
    await this.seek(frame);
    byId('message').textContent = '';
    document.body.dataset.ready = 'yes';
    if (wanted.has('play')) this.play();
  }

  tellFacts() {
    const { data } = film;
    const moving = data.bodies.filter((body) => body.type === 'dynamic').length, steps = data.frames.step.at(-1);
    document.title = `${data.name} - Atoll`;
    byId('title').textContent = data.name;
    byId('facts').textContent = [plural(moving, 'moving body'), plural(data.joints.length, 'joint'),
                                 ...(steps ? [plural(steps, 'step'), `${fixed(film.time(film.frames - 1), 2)} s`] : [])].join(' · ');
    if (data.related.address) {
      const link = byId('related').firstElementChild;
      link.href = data.related.address;
      link.textContent = data.related.text;
      byId('related').hidden = false;
    }
    for (const [key, { name }] of Object.entries(colourings)) byId('colour').append(element('option', name, { value: key }));
    byId('time').hidden = film.frames === 1;
    byId('scrub').max = film.frames - 1;
    const legend = byId('strip-legend');
    const entry = (text, colour) => {
      const item = element('li', text);
      item.prepend(element('span', '', { class: 'swatch', style: `background: ${colour}` }));
      legend.append(item);
    };
    this.strip.phases.forEach(([name], i) => entry(name.replaceAll('_', ' '), this.strip.phaseColour(i)));
    entry('deepest overlap', 'var(--bad)');
    if (data.joints.length > 0) entry('widest joint gap', 'var(--engine-0)');
    if (data.contacts_end !== undefined) {
      byId('left-out').hidden = false;
      byId('left-out').textContent =
        `From step ${data.frames.step[data.contacts_end]} on contact points are left out: there are too many for one page.`;
    }
  }

  connect() {
    byId('play').onclick = () => (this.playing ? this.pause() : this.play());
    byId('first').onclick = () => this.step(-Infinity);
    byId('back').onclick = () => this.step(-1);
    byId('forward').onclick = () => this.step(1);
    byId('scrub').oninput = () => this.seek(Number(byId('scrub').value));
    byId('home').onclick = () => this.lookAtAll();
    byId('unpick').onclick = () => this.select(null);
    for (const id of ['colour', 'contacts', 'joints', 'boxes']) {
      byId(id).onchange = () => {
        this.applyLooks();
        this.seek(this.current);
      };
    }
    this.stage.controls.addEventListener('change', () => this.stage.draw());
    // Other walls may be in the way then.
    this.stage.controls.addEventListener('end', () => this.playing || this.seek(this.current));
    let down = null;
    this.stage.canvas.addEventListener('pointerdown', (event) => (down = [event.clientX, event.clientY]));
    this.stage.canvas.addEventListener('click', (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;  // it was a turn
      const box = this.stage.canvas.getBoundingClientRect();
      this.select(this.stage.pick(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height));
    });
    const keys = {
      ' ': () => (this.playing ? this.pause() : this.play()),
      ArrowLeft: () => this.step(-1),
      ArrowRight: () => this.step(1),
      Home: () => this.step(-Infinity),
      End: () => this.step(Infinity),
      Escape: () => this.select(null),
      h: () => this.lookAtAll(),
      c: () => {
        const ways = Object.keys(colourings);
        byId('colour').value = ways[(ways.indexOf(byId('colour').value) + 1) % ways.length];
        byId('colour').onchange();
      },
    };
    document.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest('select')) return;
      const own = event.target.closest('button, input');
      if (own && (event.key === ' ' || (own.type === 'range' && event.key !== 'h' && event.key !== 'c'))) return;
      const act = keys[event.key] ?? keys[event.key.toLowerCase()];
      if (!act) return;
      event.preventDefault();
      act();
    });
    new ResizeObserver(() => {
      this.stage.resize();
      this.stage.draw();
      this.strip.forget();
      this.strip.draw(this.current);
    }).observe(byId('picture'));
    const dark = window.matchMedia('(prefers-color-scheme: dark)');
    const dress = () => {
      this.stage.background(getComputedStyle(document.body).getPropertyValue('--panel').trim());
      this.strip.forget();
    };
    dark.addEventListener('change', () => {
      dress();
      this.seek(this.current);
    });
    dress();
  }

  applyLooks() {
    this.stage.way = byId('colour').value;
    this.stage.joints.object.visible = byId('joints').checked;
    this.stage.boxes.object.visible = byId('boxes').checked;
    this.stage.contacts.object.visible = this.stage.forces.object.visible = byId('contacts').checked;
    const legend = byId('legend');
    legend.replaceChildren();
    const { legend: entries } = colourings[this.stage.way];
    for (const { before = '', text, from, wide } of entries) {
      const item = element('li', text);
      item.prepend(before, element('span', '', { class: wide ? 'swatch wide' : 'swatch', style: `background: ${from}` }));
      legend.append(item);
    }
  }

  lookAtAll() {
    const frame = film.frame(this.current);
    if (!frame) return;
    this.stage.frameAll(frame);
    this.stage.draw();
  }

  select(body) {
    this.stage.selected = body;
    this.seek(this.current);
  }

  // Shows a frame once it is there, unless another was asked for meanwhile.
  async seek(number) {
    const asked = ++this.asked;
    const bounded = Math.min(Math.max(number, 0), film.frames - 1);
    const frame = film.frame(bounded) ?? await film.loadFrame(bounded);
    const former = bounded > 0 ? film.frame(bounded - 1) ?? await film.loadFrame(bounded - 1) : null;
    const contacts = byId('contacts').checked ? await film.contacts(bounded) : null;
    if (asked !== this.asked) return false;
    if (film.chunkOf(bounded) + 1 < film.data.chunks.length) film.load(film.chunkOf(bounded) + 1);
    frame.number = bounded;
    if (former) former.seconds = film.time(bounded) - film.time(bounded - 1);
    this.current = bounded;
    this.stage.show(frame, former);
    if (contacts) this.stage.showContacts(contacts, 50 * film.data.precision);
    this.stage.draw();
    this.strip.draw(bounded);
    this.tellTime();
    this.tellBody(frame, former);
    return true;
  }

  tellTime() {
    const { frames } = film.data, step = frames.step[this.current];
    byId('scrub').value = this.current;
    byId('scrub').setAttribute('aria-valuetext', `step ${step}`);
    byId('now').textContent = `step ${step} · ${fixed(film.time(this.current), 3)} s · ${frames.ms[this.current]} ms`;
    document.body.dataset.step = step;
  }

  tellBody(frame, former) {
    const number = this.stage.selected, panel = byId('panel');
    const pose = number === null ? null : film.pose(frame, number);
    panel.hidden = !pose;
    if (!pose) return;
    const body = film.bodies[number], seen = this.stage.bodyIn(frame, former, number);
    const velocity = this.stage.velocity(frame, former, number);
    byId('picked').textContent = body.name || `Body ${body.id[0]}`;
    const rows = [
      ['id', `${body.id[0]} (generation ${body.id[1]})`],
      ['type', body.type + (body.sensor ? ', sensor' : '')],
      ['shape', film.data.shapes[body.shape].type],
      ...(body.mass ? [['mass', `${Number(body.mass.toPrecision(5))} kg`]] : []),
      ['material', `friction ${body.friction}, restitution ${body.restitution}`],
      ['position', `${vector(pose.position, 4)} m`],
      ['orientation', vector(pose.orientation, 4)],
      ...(velocity ? [['velocity', `${vector(velocity.toArray(), 3)} m/s`]] : []),
      ['contact force', `${Number(Film.force(seen.force).toPrecision(2))} N`],
      ['island', seen.island ? `of body ${film.bodies[seen.island - 1].id[0]}` : 'none'],
      ['asleep', seen.flags & Flag.asleep ? 'yes' : 'no'],
      ...(seen.flags & Flag.quarantined ? [['quarantine', 'yes']] : []),
    ];
    byId('numbers').replaceChildren(...rows.flatMap(([name, text]) => [element('dt', name), element('dd', text)]));
    panel.dataset.position = pose.position.join(' ');
  }

  step(count) {
    this.pause();
    this.seek(this.current + count);
  }

  showPlaying(playing) {
    this.playing = playing;
    byId('play').querySelector('path').setAttribute('d', playing ? 'M5 3v10M11 3v10' : 'M4 3l9 5-9 5z');
    byId('play').setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }

  pause() {
    this.showPlaying(false);
  }

  play() {
    if (this.current === film.frames - 1) this.current = 0;
    this.showPlaying(true);
    let before = performance.now(), at = film.time(this.current);
    let shown = 0;
    const began = before;
    const tick = async (now) => {
      if (!this.playing) return;
      at += Math.min((now - before) / 1000, 0.1) * Number(byId('speed').value);
      before = now;
      let frame = this.current;
      while (frame + 1 < film.frames && film.time(frame + 1) <= at) ++frame;
      if (frame !== this.current && await this.seek(frame)) ++shown;
      document.body.dataset.rate = (1000 * shown / Math.max(1, performance.now() - began)).toFixed(1);
      if (this.current === film.frames - 1) return this.pause();
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }
}

const player = new Player();
player.start().catch((error) => {
  byId('message').textContent = `This film can't be shown: ${error.message}`;
  throw error;
});
window.atoll = { film, player };
