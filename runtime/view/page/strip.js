// Plots the time and the error of each step under the time line: a click goes to the step.

const PHASE_HUES = [210, 40, 160, 280, 15, 90, 0];

const maximum = (values) => values.reduce((max, value) => Math.max(max, value), 0);

export class Strip {
  constructor(canvas, film, seek) {
    this.canvas = canvas;
    this.frames = film.data.frames;
    this.count = film.frames;
    this.phases = Object.entries(this.frames.phase_ms);
    this.max = maximum(this.frames.ms) || 1;
    const move = (event) => {
      const box = canvas.getBoundingClientRect();
      const part = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
      seek(Math.round(part * (this.count - 1)));
    };
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      move(event);
    });
    canvas.addEventListener('pointermove', (event) => event.buttons && move(event));
  }

  phaseColour(i) { return `hsl(${PHASE_HUES[i]} 45% 58%)`; }

  draw(current) {
    const { canvas } = this, ratio = Math.min(window.devicePixelRatio, 2);
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (width === 0) return;
    if (!this.base || this.base.width !== width * ratio) this.base = this.drawBase(width, height, ratio);
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const context = canvas.getContext('2d');
    context.drawImage(this.base, 0, 0);
    context.scale(ratio, ratio);
    const x = this.count > 1 ? (current / (this.count - 1)) * (width - 1) : 0;
    context.fillStyle = getComputedStyle(canvas).color;
    context.fillRect(x - 0.75, 0, 1.5, height);
  }

  forget() { this.base = null; }

  // Above: ms by phase, stacked. Below: the deepest overlap, and how far joints are open, by their logarithms.
  drawBase(width, height, ratio) {
    const base = document.createElement('canvas');
    base.width = width * ratio;
    base.height = height * ratio;
    const context = base.getContext('2d');
    context.scale(ratio, ratio);
    const split = Math.round(0.6 * height), columns = Math.min(this.count, width);
    const style = getComputedStyle(this.canvas);
    for (let column = 0; column < columns; ++column) {
      const from = Math.floor((column * this.count) / columns);
      const to = Math.max(from + 1, Math.floor(((column + 1) * this.count) / columns));
      const x = (column * width) / columns, wide = width / columns + 0.5;
      let slowest = from;
      for (let frame = from; frame < to; ++frame) if (this.frames.ms[frame] > this.frames.ms[slowest]) slowest = frame;
      let y = split;
      this.phases.forEach(([, ms], i) => {
        const tall = (ms[slowest] / this.max) * (split - 2);
        context.fillStyle = this.phaseColour(i);
        context.fillRect(x, y - tall, wide, tall);
        y -= tall;
      });
    }
    const line = (values, colour) => {
      const level = (value) => Math.min(Math.max((Math.log10(Math.max(value, 1e-7)) + 7) / 7, 0), 1);  // 0.1 um to 1 m
      context.strokeStyle = colour;
      context.lineWidth = 1.4;
      context.beginPath();
      for (let column = 0; column < columns; ++column) {
        const from = Math.floor((column * this.count) / columns);
        const to = Math.max(from + 1, Math.floor(((column + 1) * this.count) / columns));
        const y = height - 1 - level(maximum(values.slice(from, to))) * (height - split - 3);
        context[column === 0 ? 'moveTo' : 'lineTo']((column * width) / columns, y);
      }
      context.stroke();
    };
    context.fillStyle = style.getPropertyValue('--line');
    context.fillRect(0, split, width, 1);
    line(this.frames.overlap, style.getPropertyValue('--bad'));
    if (maximum(this.frames.joint_gap) > 0) line(this.frames.joint_gap, style.getPropertyValue('--engine-0'));
    return base;
  }
}
