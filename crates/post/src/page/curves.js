// Curves over time: a figure for each panel, with axes, units, a legend that tells the newest values, and a line at the mouse.

/** A number in four digits, as `estar plot` writes it. */
export function short(number) {
  if (number === null || number === undefined || !Number.isFinite(number)) return "–";
  const magnitude = Math.abs(number);
  if (number === 0 || (magnitude >= 1e-3 && magnitude < 1e5)) return String(Number(number.toPrecision(4)));
  return number.toExponential(3).replace(/\.?0+e/, "e").replace("e+", "e");
}

/** Round numbers that divide a range, and their step. */
function ticks(low, high, most) {
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= rough) ?? rough;
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  const count = Math.min(last - first, 50);
  return Array.from({ length: Math.max(count + 1, 0) }, (_, i) => (first + i) * step);
}

const isDark = matchMedia("(prefers-color-scheme: dark)");
const words = (tick) => short(Math.abs(tick) < 1e-300 ? 0 : tick);

export class Curves {
  constructor(place) {
    this.place = place;
    this.figures = [];
    this.colours = [];
    this.at = null;
    new ResizeObserver(() => this.draw()).observe(place);
    isDark.addEventListener("change", () => this.draw());
  }

  /** Shows what the server tells of the history. */
  show({ time, panels }) {
    this.time = time;
    const names = JSON.stringify(panels.map(({ label, curves }) => [label, curves.map(({ name }) => name)]));
    if (names !== this.names) {
      this.names = names;
      this.figures = panels.map((panel, index) => this.figure(panel, index === 0));
      this.place.replaceChildren(...this.figures.map(({ element }) => element));
    }
    panels.forEach((panel, index) => (this.figures[index].panel = panel));
    this.draw();
  }

  figure(panel, isWide) {
    const element = document.createElement("figure");
    element.classList.toggle("wide", isWide);
    const caption = document.createElement("figcaption");
    const title = document.createElement("b");
    const unit = document.createElement("span");
    title.textContent = panel.label;
    unit.textContent = panel.unit !== "" ? ` [${panel.unit}]` : panel.is_probe ? " [SI]" : "";
    const legend = document.createElement("ul");
    const values = panel.curves.map(({ name }, index) => {
      const item = document.createElement("li");
      const colour = document.createElement("i");
      const label = document.createElement("span");
      const value = document.createElement("output");
      label.textContent = panel.curves.length > 1 ? name : "";
      item.append(colour, label, value);
      legend.append(item);
      return { colour, value, index };
    });
    caption.append(title, unit, legend);
    caption.classList.toggle("single", panel.curves.length === 1);
    const canvas = document.createElement("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${panel.label} over time`);
    canvas.addEventListener("pointermove", (event) => {
      this.at = event.offsetX;
      this.draw();
    });
    canvas.addEventListener("pointerleave", () => {
      this.at = null;
      this.draw();
    });
    element.append(caption, canvas);
    return { element, canvas, values, panel };
  }

  /** Draws when the browser draws next. */
  draw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.figures.forEach((figure) => this.drawFigure(figure));
    });
  }

  colour(index, ink) {
    const [red, green, blue] = this.colours[index % this.colours.length] ?? [0, 114, 178];
    // the black one is that of the text, and the others are paler where the ground is dark
    if (red + green + blue === 0) return ink;
    const pale = isDark.matches ? 0.3 : 0;
    return `rgb(${[red, green, blue].map((part) => Math.round(part + pale * (255 - part))).join(" ")})`;
  }

  drawFigure({ canvas, values, panel }) {
    const style = getComputedStyle(this.place);
    const [ink, soft, grid] = ["--ink", "--soft", "--grid"].map((name) => style.getPropertyValue(name).trim());
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width === 0) return;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.font = "12px system-ui, 'DejaVu Sans', sans-serif";

    const isShown = (value) => value !== null && (!panel.is_logarithmic || value > 0);
    const height_of = (value) => (panel.is_logarithmic ? Math.log10(value) : value);
    let [low, high] = [Infinity, -Infinity];
    for (const { values: numbers } of panel.curves) {
      for (const value of numbers) {
        if (!isShown(value)) continue;
        low = Math.min(low, height_of(value));
        high = Math.max(high, height_of(value));
      }
    }
    if (!(low <= high)) [low, high] = [0, 1];
    // a curve as flat as rounding is a line and no noise
    const least = Math.max(Math.abs(low), Math.abs(high)) * 1e-6 || 1;
    if (high - low < least) [low, high] = [low - least, high + least];
    const margin = 0.06 * (high - low);
    [low, high] = [low - margin, high + margin];
    const start = this.time[0] ?? 0;
    const end = Math.max(this.time.at(-1) ?? 1, start + Number.MIN_VALUE);

    const marks = panel.is_logarithmic
      ? ticks(low, high, 4).filter((tick) => Number.isInteger(tick)).map((tick) => [tick, words(10 ** tick)])
      : ticks(low, high, Math.max(3, Math.floor(height / 34))).map((tick) => [tick, words(tick)]);
    const left = 10 + Math.max(24, ...marks.map(([, text]) => context.measureText(text).width));
    const box = { left, right: width - 10, top: 8, bottom: height - 22 };
    const x = (time) => box.left + ((time - start) / (end - start)) * (box.right - box.left);
    const y = (value) => box.bottom - ((value - low) / (high - low)) * (box.bottom - box.top);

    context.lineWidth = 1;
    context.fillStyle = soft;
    context.textBaseline = "middle";
    context.textAlign = "right";
    for (const [tick, text] of marks) {
      context.strokeStyle = !panel.is_logarithmic && tick === 0 ? soft : grid;
      line(context, [[box.left, y(tick)], [box.right, y(tick)]]);
      context.fillText(text, box.left - 6, y(tick));
    }
    context.textBaseline = "top";
    context.textAlign = "center";
    const name = "time [s]";
    const free = box.right - context.measureText(name).width - 10;
    for (const tick of ticks(start, end, Math.max(2, Math.floor((box.right - box.left) / 75)))) {
      context.strokeStyle = grid;
      line(context, [[x(tick), box.top], [x(tick), box.bottom]]);
      const text = words(tick);
      // the name of the axis stands at its end
      if (x(tick) + context.measureText(text).width / 2 < free) context.fillText(text, x(tick), box.bottom + 5);
    }
    context.textAlign = "right";
    context.fillText(name, box.right, box.bottom + 5);

    context.lineJoin = "round";
    context.save();
    context.beginPath();
    context.rect(box.left, 0, box.right - box.left, height);
    context.clip();
    panel.curves.forEach(({ values: numbers }, index) => {
      context.strokeStyle = this.colour(index, ink);
      context.lineWidth = 1.9;
      context.beginPath();
      let isDown = false;
      numbers.forEach((value, i) => {
        if (!isShown(value)) {
          isDown = false;
          return;
        }
        const point = [x(this.time[i]), y(height_of(value))];
        if (isDown) context.lineTo(...point);
        else context.moveTo(...point);
        isDown = true;
      });
      context.stroke();
    });
    context.restore();

    let row = this.time.length - 1;
    if (this.at !== null && this.at >= box.left && row >= 0) {
      const time = start + ((Math.min(this.at, box.right) - box.left) / (box.right - box.left)) * (end - start);
      while (row > 0 && this.time[row - 1] >= time) row -= 1;
      context.strokeStyle = soft;
      line(context, [[x(this.time[row]), box.top], [x(this.time[row]), box.bottom]]);
      context.fillStyle = ink;
      context.textAlign = x(this.time[row]) > width / 2 ? "right" : "left";
      context.textBaseline = "top";
      context.fillText(` ${short(this.time[row])} s `, x(this.time[row]), box.top);
    }
    for (const { colour, value, index } of values) {
      colour.style.background = this.colour(index, ink);
      value.textContent = short(panel.curves[index].values[row]);
    }
  }
}

function line(context, points) {
  context.beginPath();
  points.forEach((point, index) => (index === 0 ? context.moveTo(...point) : context.lineTo(...point)));
  context.stroke();
}
