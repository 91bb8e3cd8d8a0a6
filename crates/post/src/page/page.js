// Asks every second how the run is, and shows what has changed.

import { Body, decode } from "./body.js";
import { Curves, short } from "./curves.js";

const SECOND = 1000;
// When a run has ended another may begin in its place.
const AFTER_END = 3 * SECOND;
const part = (id) => document.getElementById(id);

const body = new Body(part("scene"), part("triad"));
const curves = new Curves(part("curves"));

const shown = { history: null, surface: null, result: null, isAsking: false };
// What the user has chosen; no frame means the newest.
const chosen = { field: null, component: null, frame: null };
let state = null;
let surface = null;

/** A time span as the program writes it. */
function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "unknown";
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  if (seconds < 60) return `${seconds.toFixed(0)} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ${Math.floor(seconds % 60)} s`;
  return `${Math.floor(seconds / 3600)} h ${Math.floor((seconds % 3600) / 60)} min`;
}

const count = (number) => (Number.isFinite(number) ? number.toFixed(0).replace(/\B(?=(\d{3})+$)/g, "\u202f") : "–");

function prefixed(number) {
  if (!Number.isFinite(number)) return "–";
  const found = [[1e9, "G"], [1e6, "M"], [1e3, "k"]].find(([size]) => number >= size);
  return found === undefined ? number.toFixed(1) : `${(number / found[0]).toFixed(2)} ${found[1]}`;
}

function element(name, text, className) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (className !== undefined) made.className = className;
  return made;
}

function setText(place, text) {
  // what stays the same is left alone, so that a selection in it stays, too
  if (place.textContent !== text) place.textContent = text;
}

async function poll() {
  try {
    const answer = await fetch("state.json");
    if (!answer.ok) throw new Error(await answer.text());
    state = await answer.json();
    showState();
    await Promise.all([askHistory(), askSurface()]);
  } catch (error) {
    showLost(error);
  }
  setTimeout(poll, hasEnded() ? AFTER_END : SECOND);
}

const hasEnded = () => state?.summary !== null && state?.summary !== undefined;

function showLost() {
  const status = part("status");
  if (!hasEnded()) {
    status.textContent = "no connection";
    status.dataset.status = "lost";
  }
  const words = hasEnded()
    ? "The program that served this page has ended. What is shown stays."
    : "The program that served this page does not answer: it has ended, or it was stopped. This is the last that it told; `estar view` shows the rest.";
  part("notes").replaceChildren(element("p", words));
}

function showState() {
  const { progress, summary } = state;
  document.title = `${percent()}${state.title || "Estar"}`;
  setText(part("title"), state.title || "Estar");
  setText(part("directory"), state.directory);
  const status = part("status");
  const isMissed = state.status === "finished" && summary?.expectations_met === false;
  const words = {
    waiting: "waiting", running: "running", silent: "silent", killed: "ended without a result",
    stopped: "stopped, can go on", interrupted: "interrupted, can go on",
  };
  setText(status, isMissed ? "finished, expectations missed" : (words[state.status] ?? state.status));
  status.dataset.status = isMissed ? "missed" : state.status;
  body.colours = state.colours;
  body.noValue = state.no_value;
  curves.colours = state.curve_colours;
  showProgress(progress, summary);
  showNotes();
  showResult(summary);
  showLog();
  showFrames();
}

/** Share of the time that is done; none where a run of an earlier version does not tell its end. */
function share() {
  if (state.status === "finished") return 1;
  const { progress } = state;
  return progress?.end_time > 0 ? Math.min(progress.time / progress.end_time, 1) : null;
}

const percent = () => (share() === null || share() === 1 ? "" : `${(100 * share()).toFixed(0)} % · `);

function showProgress(progress, summary) {
  const done = share();
  const bar = part("bar");
  bar.dataset.status = state.status;
  part("done").style.width = `${100 * (done ?? 0)}%`;
  bar.setAttribute("aria-valuenow", (100 * (done ?? 0)).toFixed(1));
  const figures = [];
  if (progress !== null) {
    if (done !== null) figures.push(["done", `${(100 * done).toFixed(1)} %`]);
    const end = progress.end_time > 0 ? ` of ${short(progress.end_time)} s` : " s";
    figures.push(
      ["time", `${short(progress.time)}${end}`],
      ["step", count(progress.step)],
      ["time step", `${short(progress.time_step)} s`],
    );
    if (state.status === "running") figures.push(["left", duration(progress.seconds_left)]);
    figures.push(
      ["took", duration(progress.wall_seconds)],
      ["energy error", `${short(100 * progress.energy_error)} %`],
      ["element steps/s", prefixed(summary?.element_steps_per_second ?? progress.element_steps_per_second)],
      ["kinetic energy", `${short(progress.kinetic_energy)} J`],
      ["internal energy", `${short(progress.internal_energy)} J`],
      ["external work", `${short(progress.external_work)} J`],
    );
  }
  const list = part("figures");
  if (list.children.length !== figures.length) {
    list.replaceChildren(...figures.map(() => {
      const pair = element("div");
      pair.append(element("dt"), element("dd"));
      return pair;
    }));
  }
  figures.forEach(([name, value], index) => {
    const [term, number] = list.children[index].children;
    setText(term, name);
    setText(number, value);
  });
}

function showNotes() {
  const notes = state.notes.map((note) => element("p", note));
  const age = duration(state.age);
  if (state.status === "silent") notes.push(element("p", `The run has told nothing for ${age}. It may take long steps, or it was held or killed.`));
  if (state.status === "killed") notes.push(element("p", `The process of the run is gone and left no result, ${age} ago. --resume goes on from its newest checkpoint.`, "bad"));
  if (state.status === "running" && state.age > 5) notes.push(element("p", `Last news ${age} ago.`));
  if (part("notes").textContent !== notes.map((note) => note.textContent).join("")) part("notes").replaceChildren(...notes);
}

function showResult(summary) {
  const place = part("result");
  place.hidden = summary === null;
  const key = JSON.stringify(summary);
  if (summary === null || shown.result === key) return;
  shown.result = key;
  const content = [element("h2", "Result")];
  const seen = `${state.status} at t = ${short(summary.time)} s after ${count(summary.steps)} steps in ${duration(summary.wall_seconds)}`;
  const extremes = summary.extremes ?? {};
  content.push(element("p", `${seen}; largest plastic strain ${short(extremes.max_equivalent_plastic_strain)}, smallest Jacobian ${short(extremes.min_jacobian)}, energy error ${short(100 * summary.energy_error)} %.`));
  if (summary.message) content.push(element("pre", summary.message, state.status === "failed" ? "bad" : ""));
  const expectations = summary.expectations ?? [];
  if (expectations.length > 0) {
    const rows = expectations.map((outcome) => [
      outcome.probe, short(outcome.time), short(outcome.expected), short(outcome.tolerance), short(outcome.found), outcome.met ? "met" : "missed",
    ]);
    content.push(table(["expected of", "at [s]", "value", "tolerance", "found", ""], rows));
  }
  const probes = Object.entries(summary.probes ?? {});
  if (probes.length > 0) content.push(table(["probe at the end", "value [SI]"], probes.map(([name, value]) => [name, value === null ? "–" : value.toExponential(6)])));
  const state_hash = element("p", "state ");
  state_hash.append(element("code", summary.state_hash));
  content.push(state_hash);
  place.replaceChildren(...content);
}

function table(names, rows) {
  const made = element("table");
  const head = element("tr");
  head.append(...names.map((name) => element("th", name)));
  const lines = rows.map((cells) => {
    const line = element("tr");
    line.append(...cells.map((cell) => {
      const isWord = cell === "met" || cell === "missed";
      return element("td", cell, isWord ? (cell === "met" ? "good" : "bad") : /^[-–\d]/.test(cell) ? "number" : "");
    }));
    return line;
  });
  made.append(head, ...lines);
  const around = element("div", undefined, "table");
  around.append(made);
  return around;
}

function showLog() {
  const { beginning_of_log: beginning, end_of_log: end } = state;
  part("log").hidden = beginning === "";
  // what is going to be computed stands in the lines that are indented after the first
  const lines = beginning.split("\n");
  const last = lines.findIndex((line, index) => index > 0 && !line.startsWith("  "));
  setText(part("beginning"), lines.slice(0, last === -1 ? lines.length : last).join("\n"));
  const rest = end === beginning ? lines.slice(last).join("\n") : end;
  part("later").hidden = last === -1 || rest.trim() === "";
  setText(part("end"), rest);
}

function showFrames() {
  const slider = part("frame");
  const last = Math.max(state.frames - 1, 0);
  if (chosen.frame !== null && chosen.frame > last) chosen.frame = null;
  slider.max = last;
  slider.disabled = state.frames < 2;
  slider.value = chosen.frame ?? last;
  part("newest").disabled = state.frames < 2;
  part("newest").setAttribute("aria-pressed", String(chosen.frame === null));
}

async function askHistory() {
  const version = state.history_version;
  if (version === shown.history || version === "") return;
  const answer = await fetch("history.json");
  if (!answer.ok) return;
  curves.show(await answer.json());
  shown.history = version;
}

/** Asks for the surface that is to be seen, unless it is seen already. */
async function askSurface() {
  if (state === null || shown.isAsking) return;
  const { field, component, frame } = chosen;
  const wanted = JSON.stringify([state.frames_version, field, component, frame]);
  if (wanted === shown.surface) return;
  if (state.frames === 0) {
    absent("No frame yet: the body is shown as soon as the run has written one.");
    return;
  }
  const query = new URLSearchParams();
  if (field !== null) query.set("field", field);
  if (component !== null) query.set("component", component);
  if (frame !== null) query.set("frame", frame);
  shown.isAsking = true;
  try {
    const answer = await fetch(`surface?${query}`);
    if (answer.ok) {
      surface = decode(await answer.arrayBuffer());
      showSurface();
    } else if (field !== null && answer.status === 404 && chosen.field === field) {
      // another run in the same place may have other fields
      Object.assign(chosen, { field: null, component: null });
      absent(await answer.text());
    } else {
      absent(await answer.text());
    }
    shown.surface = wanted;
  } finally {
    shown.isAsking = false;
  }
  // something else may have been chosen while it came
  if (wanted !== JSON.stringify([state.frames_version, chosen.field, chosen.component, chosen.frame])) await askSurface();
}

function absent(words) {
  part("absent").hidden = false;
  part("absent").textContent = words;
  part("scale").hidden = true;
  surface = null;
  body.clear();
}

function showSurface() {
  part("absent").hidden = body.isAble;
  if (!body.isAble) part("absent").textContent = "This browser draws no WebGL 2, which the body needs. The curves do without.";
  part("scale").hidden = !body.isAble;
  showFields();
  setRange();
  body.show(surface);
  part("moment").textContent = `t = ${short(surface.time)} s`;
  part("number").textContent = `${surface.frame + 1} of ${state.frames}, ${short(surface.time)} s`;
  part("scene").dataset.frame = surface.frame;
}

const plain = (name) => name.replaceAll("_", " ");

function showFields() {
  const field = part("field");
  const names = surface.fields.map(({ name }) => name);
  if (field.dataset.names !== names.join()) {
    field.dataset.names = names.join();
    field.replaceChildren(...names.map((name) => new Option(plain(name), name)));
  }
  field.value = surface.field;
  chosen.field ??= surface.field;
  const { components } = surface.fields.find(({ name }) => name === surface.field);
  const component = part("component");
  component.hidden = components.length === 0;
  if (component.dataset.names !== components.join()) {
    component.dataset.names = components.join();
    component.replaceChildren(new Option("magnitude", ""), ...components.map((name) => new Option(name, name)));
  }
  component.value = surface.component ?? "";
}

/** The whole numbers from one end of a range to the other; none where they are too many for a colour each. */
function wholeNumbers([low, high]) {
  const isFew = Number.isInteger(low) && Number.isInteger(high) && low <= high && high - low < 12;
  return isFew ? Array.from({ length: high - low + 1 }, (_, step) => low + step) : null;
}

/** The colour of a value, as the body has it. */
function colourOf(value, [low, high]) {
  const last = state.colours.length - 1;
  const at = last * (high > low ? Math.min(Math.max((value - low) / (high - low), 0), 1) : 0.5);
  const index = Math.min(Math.floor(at), last - 1);
  return state.colours[index].map((from, i) => from + (at - index) * (state.colours[index + 1][i] - from));
}

function setRange() {
  if (surface === null) return;
  const [least, most] = surface.range ?? [0, 1];
  const own = (id, otherwise) => {
    const text = part(id).value.trim();
    const number = Number(text);
    return text !== "" && Number.isFinite(number) ? number : otherwise;
  };
  const range = [own("low", least), own("high", most)];
  part("low").placeholder = short(least);
  part("high").placeholder = short(most);
  body.range = range;
  const numbers = surface.label ? wholeNumbers(range) : null;
  const share = (step, count) => `${(100 * step) / count}%`;
  const steps = numbers === null
    ? state.colours.map((colour, index) => `rgb(${colour.join(" ")}) ${share(index, state.colours.length - 1)}`)
    : numbers.map((number, index) => `rgb(${colourOf(number, range).join(" ")}) ${share(index, numbers.length)} ${share(index + 1, numbers.length)}`);
  part("gradient").style.background = `linear-gradient(to top, ${steps.join(", ")})`;
  const values = numbers ?? [0, 0.25, 0.5, 0.75, 1].map((at) => range[0] + at * (range[1] - range[0]));
  part("ticks").className = numbers === null ? "" : "numbers";
  part("ticks").replaceChildren(...values.map((value) => element("li", short(value))).reverse());
  const component = surface.component === null ? "" : ` ${surface.component}`;
  const unit = surface.unit === null ? "" : ` [${surface.unit}]`;
  part("quantity").textContent = `${plain(surface.field)}${component}${unit}`;
  body.draw();
}

function listen() {
  part("field").addEventListener("change", (event) => {
    Object.assign(chosen, { field: event.target.value, component: null });
    part("low").value = part("high").value = "";
    askSurface().catch(showLost);
  });
  part("component").addEventListener("change", (event) => {
    chosen.component = event.target.value || null;
    part("low").value = part("high").value = "";
    askSurface().catch(showLost);
  });
  for (const id of ["low", "high"]) part(id).addEventListener("input", setRange);
  part("edges").addEventListener("change", (event) => {
    body.hasEdges = event.target.checked;
    body.draw();
  });
  part("frame").addEventListener("input", (event) => {
    const number = Number(event.target.value);
    chosen.frame = number === state.frames - 1 ? null : number;
    showFrames();
    askSurface().catch(showLost);
  });
  part("newest").addEventListener("click", () => {
    chosen.frame = null;
    showFrames();
    askSurface().catch(showLost);
  });
  const buttons = document.querySelectorAll("[data-view]");
  body.onView = () => buttons.forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.view === body.viewName())));
  body.onRestored = () => surface !== null && showSurface();
  buttons.forEach((button) => button.addEventListener("click", () => body.look(button.dataset.view)));
  body.onView();
}

listen();
poll();
