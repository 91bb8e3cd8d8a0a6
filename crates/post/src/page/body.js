// The outer surface of the body, drawn by WebGL as `estar plot` draws it: seen along parallel lines, lit from above the eye's left
// shoulder, a colour for each value, edges where the elements' faces end.

const VERTEX = `#version 300 es
uniform mat3 axes;
uniform vec3 centre;
uniform vec2 zoom;
uniform float depth;
uniform vec3 lamp;
in vec3 place;
in vec3 normal;
in float value;
in float rim;
out float shownValue;
out float shownLight;
out float shownRim;
void main() {
  vec3 seen = axes * (place - centre);
  gl_Position = vec4(seen.xy * zoom, -seen.z * depth, 1.0);
  shownLight = max(dot(normalize(axes * normal), lamp), 0.0);
  shownValue = value;
  shownRim = rim;
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform vec2 range;
uniform vec3 colours[6];
uniform vec3 noValue;
uniform float strength;
in float shownValue;
in float shownLight;
in float shownRim;
out vec4 pixel;
void main() {
  float share = range.y > range.x ? (shownValue - range.x) / (range.y - range.x) : 0.5;
  float at = clamp(share, 0.0, 1.0) * 5.0;
  vec3 colour = colours[0];
  for (int i = 0; i < 5; i++) {
    colour = mix(colour, colours[i + 1], clamp(at - float(i), 0.0, 1.0));
  }
  // what is no number comes as a number that no field has
  if (abs(shownValue) > 1e37) colour = noValue;
  colour = min(colour * (0.52 + 0.55 * shownLight), vec3(1.0));
  // pixels from the edge of the face; where faces are hardly larger than pixels their edges would hide everything
  float perPixel = fwidth(shownRim);
  float line = 1.0 - smoothstep(0.35, 1.15, shownRim / max(perPixel, 1e-9));
  float seen = 1.0 - smoothstep(0.12, 0.5, perPixel);
  colour = mix(colour, vec3(0.14, 0.11, 0.17), strength * line * seen);
  pixel = vec4(colour, 1.0);
}`;

const NO_NUMBER = 3e38;
// Faces that meet at a sharper angle than this have an edge between them (cosine).
const CREASE = 0.8;
const MARGIN = 0.08;
const VIEWS = { iso: [35, 25], x: [0, 0], y: [90, 0], z: [-90, 90] };
// Degrees for a pixel of the mouse, and for a stroke of a key.
const TURN = 0.4;
const STEP = 5;

/** What the server has packed. */
export function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let at = 4 + length;
  const take = (Type, count) => {
    const array = new Type(buffer, at, count);
    at += array.byteLength;
    return array;
  };
  const places = take(Float32Array, 3 * head.vertices);
  const corners = take(Uint32Array, head.corners);
  const values = take(Float32Array, head.corners);
  const counts = take(Uint8Array, head.faces);
  return { ...head, places, corners, values, counts };
}

/** Corners of their own for every face, around its middle, so that a crease stays sharp and an edge is known from inside. */
function triangles({ places, corners, values, counts, vertices }) {
  const normals = faceNormals(places, corners, counts);
  // faces around each vertex
  const starts = new Uint32Array(vertices + 1);
  for (const corner of corners) starts[corner + 1] += 1;
  for (let i = 0; i < vertices; i++) starts[i + 1] += starts[i];
  const around = new Uint32Array(corners.length);
  const filled = starts.slice();
  let at = 0;
  for (let face = 0; face < counts.length; face++) {
    for (let i = 0; i < counts[face]; i++) around[filled[corners[at + i]]++] = face;
    at += counts[face];
  }
  // place, normal, value, rim
  const numbers = new Float32Array(8 * (corners.length + counts.length));
  const indices = new Uint32Array(3 * corners.length);
  let [vertex, index] = [0, 0];
  at = 0;
  for (let face = 0; face < counts.length; face++) {
    const count = counts[face];
    const own = 3 * face;
    const middle = vertex + count;
    const sum = new Float64Array(7);
    let isFinite = true;
    for (let i = 0; i < count; i++) {
      const corner = corners[at + i];
      let [x, y, z] = [0, 0, 0];
      for (let k = starts[corner]; k < starts[corner + 1]; k++) {
        const other = 3 * around[k];
        const cosine = normals[other] * normals[own] + normals[other + 1] * normals[own + 1] + normals[other + 2] * normals[own + 2];
        if (cosine > CREASE) {
          x += normals[other];
          y += normals[other + 1];
          z += normals[other + 2];
        }
      }
      const size = Math.hypot(x, y, z) || 1;
      const value = Number.isFinite(values[at + i]) ? values[at + i] : NO_NUMBER;
      const row = [places[3 * corner], places[3 * corner + 1], places[3 * corner + 2], x / size, y / size, z / size, value];
      isFinite &&= Number.isFinite(row[0] + row[1] + row[2]);
      numbers.set(row, 8 * (vertex + i));
      for (let k = 0; k < 7; k++) sum[k] += row[k] / count;
    }
    for (let k = 0; k < 7; k++) numbers[8 * middle + k] = sum[k];
    numbers[8 * middle + 7] = 1;
    if (isFinite) {
      for (let i = 0; i < count; i++) {
        indices.set([middle, vertex + i, vertex + ((i + 1) % count)], index);
        index += 3;
      }
    }
    vertex += count + 1;
    at += count;
  }
  return { numbers, indices: indices.subarray(0, index) };
}

/** Newell's sums: directions also of faces that are not plane. */
function faceNormals(places, corners, counts) {
  const normals = new Float32Array(3 * counts.length);
  let at = 0;
  for (let face = 0; face < counts.length; face++) {
    const count = counts[face];
    let [x, y, z] = [0, 0, 0];
    for (let i = 0; i < count; i++) {
      const a = 3 * corners[at + i];
      const b = 3 * corners[at + ((i + 1) % count)];
      x += (places[a + 1] - places[b + 1]) * (places[a + 2] + places[b + 2]);
      y += (places[a + 2] - places[b + 2]) * (places[a] + places[b]);
      z += (places[a] - places[b]) * (places[a + 1] + places[b + 1]);
    }
    const size = Math.hypot(x, y, z) || 1;
    normals.set([x / size, y / size, z / size], 3 * face);
    at += count;
  }
  return normals;
}

export class Body {
  /** A view on a canvas, with the axes on another. */
  constructor(scene, triad) {
    this.scene = scene;
    this.triad = triad;
    this.view = [...VIEWS.iso];
    this.target = [0, 0, 0];
    this.perMetre = 1;
    this.isMoved = false;
    this.hasEdges = true;
    this.range = [0, 1];
    this.colours = [];
    this.noValue = [170, 170, 170];
    this.middle = null;
    this.onView = () => {};
    this.listen();
    this.begin();
    new ResizeObserver(() => this.resized()).observe(scene);
  }

  /** Whether this browser can draw it. */
  get isAble() {
    return this.gl !== null;
  }

  begin() {
    const gl = this.scene.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: false });
    this.gl = gl;
    if (gl === null) return;
    const program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      console.error(gl.getProgramInfoLog(program), ...gl.getAttachedShaders(program).map((shader) => gl.getShaderInfoLog(shader)));
      this.gl = null;
      return;
    }
    gl.useProgram(program);
    this.place = (name) => gl.getUniformLocation(program, name);
    this.corners = gl.createBuffer();
    this.faces = gl.createBuffer();
    this.count = 0;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.faces);
    [["place", 3, 0], ["normal", 3, 12], ["value", 1, 24], ["rim", 1, 28]].forEach(([name, size, offset]) => {
      const attribute = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(attribute);
      gl.vertexAttribPointer(attribute, size, gl.FLOAT, false, 32, offset);
    });
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
  }

  /** Shows a surface; the view stays where the user put it. */
  show(surface) {
    const { places, middle } = surface;
    const shift = this.middle === null ? [0, 0, 0] : middle.map((place, i) => this.middle[i] - place);
    // places are relative to the middle of their own frame
    this.target = this.target.map((place, i) => place + shift[i]);
    this.middle = middle;
    this.places = places;
    this.radius = 0;
    for (let i = 0; i < places.length; i += 3) {
      const size = Math.hypot(places[i], places[i + 1], places[i + 2]);
      if (size > this.radius && Number.isFinite(size)) this.radius = size;
    }
    if (this.isAble) {
      const gl = this.gl;
      const { numbers, indices } = triangles(surface);
      gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.DYNAMIC_DRAW);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.DYNAMIC_DRAW);
      this.count = indices.length;
    }
    if (!this.isMoved && !this.isFitting()) this.fit();
    this.draw();
  }

  /** Shows nothing. */
  clear() {
    this.count = 0;
    this.draw();
  }

  /** Directions to the right, up and towards the eye. */
  axes() {
    const [azimuth, elevation] = this.view.map((degrees) => (degrees * Math.PI) / 180);
    const [sa, ca, se, ce] = [Math.sin(azimuth), Math.cos(azimuth), Math.sin(elevation), Math.cos(elevation)];
    return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  }

  /** The body's extent along the directions of the view; none where there is nothing. */
  extent() {
    const { places } = this;
    const axes = this.axes();
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; places !== undefined && i < places.length; i += 3) {
      for (let k = 0; k < 3; k++) {
        const along = axes[k][0] * places[i] + axes[k][1] * places[i + 1] + axes[k][2] * places[i + 2];
        if (along < low[k]) low[k] = along;
        if (along > high[k]) high[k] = along;
      }
    }
    return high[0] >= low[0] && high[1] >= low[1] ? { low, high } : null;
  }

  /** Middle and scale at which an extent fills the picture beside the scale of colours and above the hint. */
  fitting({ low, high }) {
    const [width, height] = [this.scene.clientWidth, this.scene.clientHeight];
    const room = width > 420 ? 130 : 0;
    const wanted = [0, 1].map((k) => Math.max(high[k] - low[k], 1e-3 * this.radius, Number.MIN_VALUE));
    const perMetre = (1 - 2 * MARGIN) * Math.min((width - room) / wanted[0], (height - 24) / wanted[1]);
    const centre = [0, 1, 2].map((k) => 0.5 * (low[k] + high[k]));
    centre[0] += (0.5 * room) / perMetre;
    centre[1] -= 12 / perMetre;
    return { perMetre, centre };
  }

  /** Whether the body is still well in the picture: then its motion from frame to frame is seen against a picture that stands. */
  isFitting() {
    const extent = this.extent();
    if (extent === null) return true;
    const { perMetre, centre } = this.fitting(extent);
    const scale = this.perMetre / perMetre;
    const axes = this.axes();
    const off = [0, 1].map((k) => this.perMetre * (axes[k].reduce((sum, part, i) => sum + part * this.target[i], 0) - centre[k]));
    return scale > 0.75 && scale < 1.08 && Math.abs(off[0]) < 0.12 * this.scene.clientWidth && Math.abs(off[1]) < 0.12 * this.scene.clientHeight;
  }

  /** Puts the whole body into the picture. */
  fit() {
    this.isMoved = false;
    const extent = this.extent();
    if (extent === null) return;
    const { perMetre, centre } = this.fitting(extent);
    const axes = this.axes();
    this.perMetre = perMetre;
    this.target = [0, 1, 2].map((i) => axes[0][i] * centre[0] + axes[1][i] * centre[1] + axes[2][i] * centre[2]);
    this.draw();
  }

  /** Looks along an axis, or at the whole. */
  look(name) {
    if (name in VIEWS) this.view = [...VIEWS[name]];
    this.fit();
    this.onView();
  }

  /** The name of the view, if it has one. */
  viewName() {
    const isSame = (view) => view.every((angle, i) => (angle - this.view[i]) % 360 === 0);
    return Object.keys(VIEWS).find((name) => isSame(VIEWS[name]));
  }

  turn(right, up) {
    this.view[0] -= right;
    this.view[1] = Math.max(-90, Math.min(90, this.view[1] + up));
    // until it is moved or zoomed the whole body stays in the picture
    if (!this.isMoved) this.fit();
    this.draw();
    this.onView();
  }

  move(right, down) {
    const [x, y] = this.axes();
    this.isMoved = true;
    this.target = this.target.map((place, i) => place - (right * x[i] - down * y[i]) / this.perMetre);
    this.draw();
  }

  /** Zooms around a point of the canvas. */
  zoom(factor, [left, top] = [this.scene.clientWidth / 2, this.scene.clientHeight / 2]) {
    const [right, down] = [left - this.scene.clientWidth / 2, top - this.scene.clientHeight / 2];
    this.move(-right, -down);
    this.perMetre *= factor;
    this.move(right, down);
  }

  listen() {
    const { scene } = this;
    let last = null;
    scene.addEventListener("pointerdown", (event) => {
      last = [event.clientX, event.clientY];
      scene.setPointerCapture(event.pointerId);
    });
    scene.addEventListener("pointermove", (event) => {
      if (last === null) return;
      const [x, y] = [event.clientX - last[0], event.clientY - last[1]];
      last = [event.clientX, event.clientY];
      if (event.shiftKey || (event.buttons & 6) !== 0) this.move(x, y);
      else this.turn(TURN * x, TURN * y);
    });
    for (const end of ["pointerup", "pointercancel"]) scene.addEventListener(end, () => (last = null));
    scene.addEventListener("contextmenu", (event) => event.preventDefault());
    scene.addEventListener("dblclick", () => this.fit());
    scene.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 0 ? event.deltaY / 100 : event.deltaY / 3;
      this.zoom(1.2 ** -Math.max(-3, Math.min(3, lines)), [event.offsetX, event.offsetY]);
    }, { passive: false });
    scene.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const arrow = arrows[event.key];
      if (arrow !== undefined && event.shiftKey) this.move(20 * arrow[0], 20 * arrow[1]);
      else if (arrow !== undefined) this.turn(STEP * arrow[0], STEP * arrow[1]);
      else if (event.key === "+" || event.key === "=") this.zoom(1.2);
      else if (event.key === "-") this.zoom(1 / 1.2);
      else if (event.key === "0" || event.key === "Home") this.fit();
      else if ("xyzi".includes(event.key)) this.look(event.key === "i" ? "iso" : event.key);
      else return;
      event.preventDefault();
    });
    scene.addEventListener("webglcontextlost", (event) => event.preventDefault());
    scene.addEventListener("webglcontextrestored", () => {
      this.begin();
      this.onRestored?.();
    });
  }

  resized() {
    for (const canvas of [this.scene, this.triad]) {
      const ratio = window.devicePixelRatio || 1;
      canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
      canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    }
    if (!this.isMoved) this.fit();
    this.draw();
  }

  /** Draws when the browser draws next. */
  draw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.drawNow();
    });
  }

  drawNow() {
    this.drawTriad();
    const { gl } = this;
    if (gl === null) return;
    gl.viewport(0, 0, this.scene.width, this.scene.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (this.count === 0 || this.colours.length === 0) return;
    const axes = this.axes();
    const [width, height] = [this.scene.clientWidth, this.scene.clientHeight];
    const farthest = this.radius + Math.hypot(...this.target);
    const size = Math.hypot(-0.45, 0.6, 1);
    gl.uniformMatrix3fv(this.place("axes"), true, axes.flat());
    gl.uniform3fv(this.place("centre"), this.target);
    gl.uniform2f(this.place("zoom"), (2 * this.perMetre) / width, (2 * this.perMetre) / height);
    gl.uniform1f(this.place("depth"), farthest > 0 ? 0.99 / farthest : 1);
    gl.uniform3f(this.place("lamp"), -0.45 / size, 0.6 / size, 1 / size);
    gl.uniform2fv(this.place("range"), this.range);
    gl.uniform3fv(this.place("colours"), this.colours.flat().map((part) => part / 255));
    gl.uniform3fv(this.place("noValue"), this.noValue.map((part) => part / 255));
    gl.uniform1f(this.place("strength"), this.hasEdges ? 0.55 : 0);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
  }

  drawTriad() {
    const context = this.triad.getContext("2d");
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [this.triad.clientWidth, this.triad.clientHeight];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const [right, up, towards] = this.axes();
    const ink = getComputedStyle(this.triad).color;
    context.font = "600 13px system-ui, 'DejaVu Sans', sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    const order = [0, 1, 2].sort((a, b) => towards[a] - towards[b]);
    for (const axis of order) {
      const [x, y] = [right[axis], -up[axis]];
      context.globalAlpha = towards[axis] < -0.2 ? 0.55 : 1;
      context.strokeStyle = context.fillStyle = ["#d55e00", "#009e73", "#3b8fd6"][axis];
      context.lineWidth = 2.2;
      context.beginPath();
      context.moveTo(width / 2, height / 2);
      context.lineTo(width / 2 + 26 * x, height / 2 + 26 * y);
      context.stroke();
      context.fillStyle = ink;
      // an axis that is seen end on has its name beside the point
      const isEndOn = Math.hypot(x, y) < 0.25;
      context.fillText("xyz"[axis], width / 2 + (isEndOn ? -9 : 36 * x), height / 2 + (isEndOn ? 9 : 36 * y));
    }
    context.globalAlpha = 1;
  }
}
