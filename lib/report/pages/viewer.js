"use strict";
// Plays the stream of lib/report/stream.h: decoding and sorting on a worker, splatting with WebGL 2.
//
// mountViewer(root, header, base64) fills `root` and returns what tests and the page around it may use.

// --- The worker --------------------------------------------------------------------------------------------------

// Runs in a worker: nothing outside of it can be seen from here.
function viewerWorker() {
  const COMPONENTS = 12, HIDDEN = -32768;
  let header, rest, count, moved = [];
  const ready = [];  // frames that can be sorted

  async function inflate(bytes) {
    const packed = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(packed).arrayBuffer());
  }

  // Reads the plane at `at` into `out`; before: [last, last but one] of the same component. Returns where the next is.
  function readPlane(bytes, at, out, before, stride, offset) {
    const prediction = bytes[at], width = bytes[at + 1], order = prediction & 3, beside = prediction & 4;
    const low = at + 2, middle = low + count, high = middle + count, top = high + count;
    let last = 0;
    for (let i = 0, k = offset; i < count; ++i, k += stride) {
      let u = bytes[low + i];
      if (width > 1) u |= bytes[middle + i] << 8;
      if (width > 2) u |= bytes[high + i] << 16;
      if (width > 3) u += bytes[top + i] * 16777216;
      let value = u & 1 ? -((u + 1) / 2) : u / 2;
      if (beside) { value += last; last = value; }
      if (order === 1) value += before[0][k];
      else if (order === 2) value += 2 * before[0][k] - before[1][k];
      out[k] = value;
    }
    return low + width * count;
  }

  function readRest(bytes) {
    const planes = 14 + 3 * ((header.sh_degree + 1) ** 2 - 1) + 1, read = [];
    let at = 0;
    for (let p = 0; p < planes; ++p) {
      const values = new Int32Array(count);
      at = readPlane(bytes, at, values, [], 1, 0);
      read.push(values);
    }
    const s = header.steps, lines = Math.ceil(count / 256);
    const position = new Float32Array(3 * count), shape = new Float32Array(lines * 256 * 16);
    const harmonics = new Int8Array(header.sh_degree ? lines * 256 * 15 * 4 : 4), row = new Uint16Array(lines * 256);
    for (let i = 0; i < count; ++i) {
      const p = [0, 1, 2].map(c => header.origin[c] + read[c][i] * s.rest);
      const d = [0, 1, 2].map(c => Math.exp(read[3 + c][i] * s.log_scale));
      let [w, x, y, z] = [6, 7, 8, 9].map(c => read[c][i] * s.rotation);
      const n = Math.hypot(w, x, y, z) || 1;
      w /= n; x /= n; y /= n; z /= n;
      position.set(p, 3 * i);
      // Four texels: mean and opacity, then the columns of R S, each with a colour channel.
      const color = [11, 12, 13].map(c => read[c][i] * s.color);
      shape.set([p[0], p[1], p[2], read[10][i] * s.opacity,
        (1 - 2 * (y * y + z * z)) * d[0], 2 * (x * y + w * z) * d[0], 2 * (x * z - w * y) * d[0], color[0],
        2 * (x * y - w * z) * d[1], (1 - 2 * (x * x + z * z)) * d[1], 2 * (y * z + w * x) * d[1], color[1],
        2 * (x * z + w * y) * d[2], 2 * (y * z - w * x) * d[2], (1 - 2 * (x * x + y * y)) * d[2], color[2]], 16 * i);
      for (let k = 14; k < planes - 1; ++k)
        harmonics[(15 * i + Math.floor((k - 14) / 3)) * 4 + (k - 14) % 3] = read[k][i];
      row[i] = read[planes - 1][i];
    }
    rest = position;
    postMessage({kind: "rest", lines, shape, harmonics, row}, [shape.buffer, harmonics.buffer, row.buffer]);
  }

  async function start(bytes) {
    let at = 0, before = [];
    const chunk = k => { const part = bytes.subarray(at, at + header.chunks[k]); at += header.chunks[k]; return inflate(part); };
    readRest(await chunk(0));
    const lines = Math.ceil(count / 256);
    for (let t = 0; t < header.frames.length; ++t) {
      const began = performance.now(), plain = await chunk(t + 1), values = new Int16Array(lines * 256 * COMPONENTS);
      for (let c = 0, from = 0; c < COMPONENTS; ++c) from = readPlane(plain, from, values, before, COMPONENTS, c);
      before = [values, before[0]];
      const means = new Int16Array(4 * count);
      for (let i = 0; i < count; ++i) {
        for (let c = 0; c < 4; ++c) means[4 * i + c] = values[12 * i + c];
      }
      moved[t] = means;
      const copy = values.slice();
      postMessage({kind: "frame", t, values: copy, milliseconds: performance.now() - began}, [copy.buffer]);
    }
  }

  // Farthest first along `axis`, by a counting sort of 16 bits.
  const counts = new Uint32Array(65537);
  function sort({t, axis, id}) {
    const began = performance.now(), means = moved[t], step = header.steps.position, depth = new Float32Array(count);
    let low = Infinity, high = -Infinity;
    for (let i = 0; i < count; ++i) {
      const d = axis[0] * (rest[3 * i] + step * means[4 * i]) + axis[1] * (rest[3 * i + 1] + step * means[4 * i + 1]) +
                axis[2] * (rest[3 * i + 2] + step * means[4 * i + 2]);
      depth[i] = d;
      if (d < low) low = d;
      if (d > high) high = d;
    }
    const scale = high > low ? 65535 / (high - low) : 0, key = new Uint16Array(count), order = new Uint32Array(count);
    counts.fill(0);
    for (let i = 0; i < count; ++i) {
      key[i] = (high - depth[i]) * scale;
      ++counts[key[i] + 1];
    }
    for (let k = 0; k < 65536; ++k) counts[k + 1] += counts[k];
    for (let i = 0; i < count; ++i) order[counts[key[i]]++] = i;
    postMessage({kind: "order", id, t, order, milliseconds: performance.now() - began}, [order.buffer]);
  }

  onmessage = async event => {
    const message = event.data;
    try {
      if (message.kind === "start") {
        header = message.header;
        count = header.gaussians;
        await start(message.bytes);
      } else if (moved[message.t]) {
        sort(message);
      }
    } catch (error) {
      postMessage({kind: "error", text: String(error)});
    }
  };
}

// --- Shaders -----------------------------------------------------------------------------------------------------

// The projection of lib/splat/projection.cpp.
const SPLAT_VERTEX = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D; precision highp isampler2D; precision highp usampler2D;
uniform sampler2D shape, rowTable;
uniform isampler2D before, after, harmonics;
uniform usampler2D rowOf;
uniform float blend, near, seconds, quickest, largest;
uniform vec2 steps, focal, middle, size;   // pixels
uniform float harmonicStep;
uniform mat3 turn;                         // world to camera
uniform vec3 eye;
uniform int degree, colours, dots;
uniform vec4 flatten;                      // a plane that everything is laid on: normal and offset; no normal: none
layout(location = 0) in uint index;
out vec2 uv;
out vec4 paint;

vec3 heat(float x) {
  x = clamp(x, 0.0, 1.0);
  vec3 a = vec3(0.17, 0.28, 0.55), b = vec3(0.16, 0.60, 0.60), c = vec3(0.95, 0.83, 0.35), d = vec3(0.86, 0.30, 0.20);
  return x < 0.33 ? mix(a, b, x / 0.33) : x < 0.66 ? mix(b, c, (x - 0.33) / 0.33) : mix(c, d, (x - 0.66) / 0.34);
}

mat3 polar(mat3 F) {
  if (determinant(F) < 1e-6) return mat3(1.0);
  for (int k = 0; k < 12; ++k) F = 0.5 * (F + transpose(inverse(F)));
  return F;
}

vec3 harmonic(ivec2 at, int k) {
  return vec3(texelFetch(harmonics, at + ivec2(k - 1, 0), 0).xyz) * harmonicStep;
}

vec3 shaded(vec3 base, ivec2 at, vec3 d) {
  vec3 c = base;
  if (degree < 1) return max(c, 0.0);
  float x = d.x, y = d.y, z = d.z;
  c += 0.4886025119029199 * (-y * harmonic(at, 1) + z * harmonic(at, 2) - x * harmonic(at, 3));
  if (degree < 2) return max(c, 0.0);
  float xx = x * x, yy = y * y, zz = z * z;
  c += 1.0925484305920792 * (x * y * harmonic(at, 4) - y * z * harmonic(at, 5) - x * z * harmonic(at, 7)) +
       0.31539156525252005 * (2.0 * zz - xx - yy) * harmonic(at, 6) + 0.5462742152960396 * (xx - yy) * harmonic(at, 8);
  if (degree < 3) return max(c, 0.0);
  c += -0.5900435899266435 * y * (3.0 * xx - yy) * harmonic(at, 9) + 2.890611442640554 * x * y * z * harmonic(at, 10) -
       0.4570457994644658 * y * (4.0 * zz - xx - yy) * harmonic(at, 11) +
       0.3731763325901154 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy) * harmonic(at, 12) -
       0.4570457994644658 * x * (4.0 * zz - xx - yy) * harmonic(at, 13) + 1.445305721320277 * z * (xx - yy) * harmonic(at, 14) -
       0.5900435899266435 * x * (xx - 3.0 * yy) * harmonic(at, 15);
  return max(c, 0.0);
}

void main() {
  gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
  int i = int(index);
  ivec2 cell = ivec2(i & 255, i >> 8);
  ivec4 a0 = texelFetch(before, ivec2(3 * cell.x, cell.y), 0);
  if (a0.w == ${-32768}) return;
  vec4 table = texelFetch(rowTable, ivec2(int(texelFetch(rowOf, cell, 0).x), 0), 0);
  float modulus = texelFetch(rowTable, ivec2(int(texelFetch(rowOf, cell, 0).x), 1), 0).x;
  if (table.w < 0.5) return;
  vec4 p = vec4(a0), q = vec4(texelFetch(before, ivec2(3 * cell.x + 1, cell.y), 0)), r = vec4(texelFetch(before, ivec2(3 * cell.x + 2, cell.y), 0));
  vec3 speed = vec3(0.0);
  if (blend > 0.0 || colours == 2) {
    ivec4 b0 = texelFetch(after, ivec2(3 * cell.x, cell.y), 0);
    if (b0.w != ${-32768}) {
      speed = vec3(b0.xyz - a0.xyz) * steps.x / seconds;
      p = mix(p, vec4(b0), blend);
      q = mix(q, vec4(texelFetch(after, ivec2(3 * cell.x + 1, cell.y), 0)), blend);
      r = mix(r, vec4(texelFetch(after, ivec2(3 * cell.x + 2, cell.y), 0)), blend);
    }
  }
  vec4 at = texelFetch(shape, ivec2(4 * cell.x, cell.y), 0);
  vec4 m0 = texelFetch(shape, ivec2(4 * cell.x + 1, cell.y), 0), m1 = texelFetch(shape, ivec2(4 * cell.x + 2, cell.y), 0),
       m2 = texelFetch(shape, ivec2(4 * cell.x + 3, cell.y), 0);
  float opacity = at.w;
  // By columns; the stream has rows.
  mat3 F = mat3(1.0) + steps.y * mat3(p.w, q.z, r.y, q.x, q.w, r.z, q.y, r.x, r.w);
  vec3 mean = at.xyz + steps.x * p.xyz;
  mat3 M = F * mat3(m0.xyz, m1.xyz, m2.xyz);
  if (dots == 1) {
    opacity = 1.0;
    M = mat3(largest);
  }
  float height = 0.0;
  if (flatten.xyz != vec3(0.0)) {
    height = dot(flatten.xyz, mean) - flatten.w;
    if (height < -largest * 4.0) return;
    mean -= height * flatten.xyz;
    M -= outerProduct(flatten.xyz, transpose(M) * flatten.xyz);
    opacity *= exp(-height * height / (seconds * seconds));
  }
  vec3 t = turn * (mean - eye);
  if (!(t.z > near) || opacity < 1.0 / 255.0) return;
  vec2 margin = 0.15 * size / focal;
  vec2 slope = clamp(t.xy / t.z, -middle / focal - margin, (size - middle) / focal + margin);
  mat3 T = turn * M;
  vec3 third = vec3(T[0].z, T[1].z, T[2].z);
  vec3 t0 = focal.x / t.z * (vec3(T[0].x, T[1].x, T[2].x) - slope.x * third);
  vec3 t1 = focal.y / t.z * (vec3(T[0].y, T[1].y, T[2].y) - slope.y * third);
  float rawX = dot(t0, t0), rawY = dot(t1, t1), xx = rawX + 0.3, yy = rawY + 0.3, xy = dot(t0, t1);
  vec3 area = cross(t0, t1);
  float det = dot(area, area) + 0.3 * (rawX + rawY) + 0.09;
  float reach = sqrt(max(2.0 * log(255.0 * opacity), 0.0)) + 1e-3;
  float a = sqrt(yy / det), b = -xy / sqrt(det) / sqrt(yy), c = 1.0 / sqrt(yy);
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  uv = corner * reach;
  float dy = uv.y / c;
  vec2 pixel = focal * t.xy / t.z + middle + vec2((uv.x - b * dy) / a, dy);
  gl_Position = vec4(pixel.x / size.x * 2.0 - 1.0, 1.0 - pixel.y / size.y * 2.0, 0.0, 1.0);

  vec3 base = vec3(m0.w, m1.w, m2.w), colour;
  if (colours == 0) {
    vec3 d = normalize(mean - eye);
    if (degree > 0) d = transpose(polar(F)) * d;
    colour = shaded(base, ivec2(15 * cell.x, cell.y), normalize(d));
  } else {
    float light = 0.65 + 0.7 * clamp(dot(base, vec3(1.0 / 3.0)), 0.0, 1.0);
    mat3 E = 0.5 * (transpose(F) * F - mat3(1.0));
    if (colours == 4) E -= mat3((E[0].x + E[1].y + E[2].z) / 3.0);
    float strain = sqrt(dot(E[0], E[0]) + dot(E[1], E[1]) + dot(E[2], E[2]));
    float value = colours == 2 ? length(speed) / quickest : colours == 3 ? strain / quickest : modulus * strain / quickest;
    colour = (colours == 1 ? table.xyz : heat(value)) * light;
  }
  paint = vec4(colour, opacity);
}`;

const SPLAT_FRAGMENT = `#version 300 es
precision highp float;
in vec2 uv;
in vec4 paint;
out vec4 result;
void main() {
  float alpha = min(0.99, paint.w * exp(-0.5 * dot(uv, uv)));
  if (alpha < 1.0 / 255.0) discard;
  result = vec4(min(paint.xyz, vec3(1.0 / alpha)) * alpha, alpha);
}`;

// The floor: a ray per pixel meets the plane, where it sees its shade and the shadows; both fade with the distance.
const FLOOR_VERTEX = `#version 300 es
out vec2 place;
void main() {
  place = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);
}`;
const FLOOR_FRAGMENT = `#version 300 es
precision highp float;
in vec2 place;
uniform mat3 turn;
uniform vec3 eye, normal, middlePoint, alongU, alongV, ground;
uniform vec2 focal, middle, size;
uniform float reach;
uniform sampler2D shadow;
out vec4 result;
void main() {
  result = vec4(0.0);
  vec2 pixel = vec2(place.x, 1.0 - place.y) * size;
  vec3 ray = transpose(turn) * vec3((pixel - middle) / focal, 1.0);
  float down = dot(normal, ray), height = dot(normal, eye - middlePoint);
  if (down >= -1e-6 || height <= 0.0) return;
  vec3 hit = eye - ray * (height / down) - middlePoint;
  vec2 at = vec2(dot(hit, alongU), dot(hit, alongV)) / reach;
  float fade = exp(-2.2 * dot(at, at));
  vec2 tex = at * 0.5 + 0.5;
  float dark = 0.0;
  for (int k = 0; k < 12; ++k) {
    float angle = 2.3999632 * float(k), radius = 0.0035 * sqrt(float(k));
    dark += texture(shadow, tex + radius * vec2(cos(angle), sin(angle))).a / 12.0;
  }
  if (any(lessThan(tex, vec2(0.0))) || any(greaterThan(tex, vec2(1.0)))) dark = 0.0;
  float light = dot(ground, vec3(0.333)) > 0.4 ? -1.0 : 1.0;
  vec3 shade = ground + light * 0.05 * fade;
  float alpha = min(1.0, 0.42 * dark * fade);
  // Half a level of noise: eight bits would show the fading in bands.
  float noise = fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453) - 0.5;
  result = vec4(shade * (1.0 - alpha) + noise / 255.0, 1.0);
}`;

// --- The viewer --------------------------------------------------------------------------------------------------

function mountViewer(root, header, base64) {
  const $ = (tag, properties = {}, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  };
  const frameCount = header.frames.length, times = header.times, rows = header.rows;
  const aria = (element, name, value) => (element.setAttribute("aria-" + name, value), element);

  // --- The page
  const canvas = aria($("canvas", {className: "v-canvas", tabIndex: 0}), "label",
    "Moving Gaussians. Drag to turn, scroll to come nearer, arrow keys step through the frames, space plays.");
  canvas.setAttribute("role", "img");
  const word = $("div", {className: "v-word", role: "status"}, "Loading…");
  const play = aria($("button", {className: "v-play v-icon", type: "button"}), "label", "Play");
  const scrub = aria($("input", {type: "range", min: 0, max: frameCount - 1, step: "any", value: 0, className: "v-scrub"}), "label", "Time");
  const clock = $("span", {className: "v-clock"}, "0.00 s");
  const choice = (label, options, act) => {
    const select = aria($("select"), "label", label);
    for (const [value, text] of options) select.append($("option", {value}, text));
    select.addEventListener("change", () => act(select.value));
    return select;
  };
  const speed = choice("Speed", [["0.1", "0.1×"], ["0.25", "¼×"], ["0.5", "½×"], ["1", "1×"], ["2", "2×"]], () => {});
  speed.value = "1";
  const colours = choice("Colours", [["0", "As captured"], ["1", "Parts"], ["2", "Speed"], ["3", "Strain"],
    ...(rows.some(r => r.modulus) ? [["4", "Stress"]] : [])], () => changed());
  const ground = choice("Background", [["auto", "Background"], ["white", "White"], ["grey", "Grey"], ["black", "Black"]], () => changed());
  const seen = choice("Camera", [["video", "Video camera"], ["own", "My camera"], ["front", "Front"], ["side", "Side"],
    ["back", "Back"], ["top", "Top"]], name => lookFrom(name));
  const dots = $("button", {type: "button", className: "v-toggle", textContent: "Particles"});
  const floor = $("button", {type: "button", className: "v-toggle", textContent: "Floor"});
  for (const button of [dots, floor]) {
    aria(button, "pressed", "false");
    button.addEventListener("click", () => { aria(button, "pressed", String(!pressed(button))); changed(); });
  }
  const pressed = button => button.getAttribute("aria-pressed") === "true";
  const parts = aria($("div", {className: "v-parts", role: "group"}), "label", "Parts: choose one to see it alone");
  const chips = rows.map((row, r) => {
    const spot = $("i");
    spot.style.background = `rgb(${row.color.map(c => Math.round(255 * c))})`;
    const chip = aria($("button", {type: "button", className: "v-chip", title: `${row.key}: ${row.count} Gaussians`}, spot, row.name), "pressed", "false");
    chip.addEventListener("click", () => alone(state.alone === r ? -1 : r));
    return chip;
  });
  parts.append(...chips.filter((chip, r) => rows[r].count > 0));
  const legend = $("div", {className: "v-legend", hidden: true});
  const full = aria($("button", {type: "button", className: "v-icon v-full"}), "label", "Fill the screen");
  root.classList.add("viewer");
  root.append($("div", {className: "v-stage"}, canvas, word, legend, parts),
    $("div", {className: "v-bar"}, $("div", {className: "v-line"}, play, scrub, clock, full),
      $("div", {className: "v-line v-choices"}, speed, colours, seen, ground, dots, floor)));
  if (rows.filter(row => row.count > 0).length < 2) parts.hidden = true;

  const fail = text => { word.textContent = text; word.hidden = false; root.classList.add("v-failed"); };
  const gl = canvas.getContext("webgl2", {alpha: false, antialias: false, preserveDrawingBuffer: true, powerPreference: "high-performance"});
  if (!gl) { fail("This browser has no WebGL 2, which this viewer needs."); return {failed: true}; }
  if (typeof DecompressionStream === "undefined") { fail("This browser cannot unpack the stream: it has no DecompressionStream."); return {failed: true}; }

  // --- WebGL
  function program(vertex, fragment) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    const places = {};
    const used = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS);
    for (let k = 0; k < used; ++k) {
      const name = gl.getActiveUniform(made, k).name;
      places[name] = gl.getUniformLocation(made, name);
    }
    return {made, places};
  }
  const splats = program(SPLAT_VERTEX, SPLAT_FRAGMENT), plane = program(FLOOR_VERTEX, FLOOR_FRAGMENT);
  function texture(inner, width, height, format, type, data) {
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texStorage2D(gl.TEXTURE_2D, 1, inner, width, height);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, format, type, data);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return made;
  }
  const SHADOW = 512;
  const shadowTexture = texture(gl.RGBA8, SHADOW, SHADOW, gl.RGBA, gl.UNSIGNED_BYTE, null);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
  const shadowTarget = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, shadowTarget);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, shadowTexture, 0);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  const cells = gl.createVertexArray(), empty = gl.createVertexArray(), indices = gl.createBuffer();
  gl.bindVertexArray(cells);
  gl.bindBuffer(gl.ARRAY_BUFFER, indices);
  gl.bufferData(gl.ARRAY_BUFFER, 4 * header.gaussians, gl.DYNAMIC_DRAW);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribIPointer(0, 1, gl.UNSIGNED_INT, 0, 0);
  gl.vertexAttribDivisor(0, 1);
  gl.bindVertexArray(null);

  // --- What there is
  const frames = new Array(frameCount), lights = {};
  let lines = 0, shapeTexture, harmonicsTexture, rowTexture, tableTexture;
  const held = [{t: -1, texture: null}, {t: -1, texture: null}];  // frames on the GPU
  const statistics = {decode: [], sort: [], upload: [], draw: []};
  const state = {time: 0, playing: false, alone: -1, dirty: true, sorted: null, waiting: false, drawn: -1, loaded: 0};

  // --- Vectors
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const plus = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
  const unit = a => { const n = Math.hypot(...a) || 1; return a.map(x => x / n); };
  // a turned about the unit axis n.
  const turned = (a, n, angle) => {
    const c = Math.cos(angle), s = Math.sin(angle), k = dot(n, a) * (1 - c), x = cross(n, a);
    return [0, 1, 2].map(i => a[i] * c + x[i] * s + n[i] * k);
  };

  // --- Camera: right, down and forward in the scene, and where it stands
  const up = header.up;
  let camera;
  const videoCamera = t => {
    const c = header.cameras[Math.min(header.cameras.length - 1, Math.max(0, t))];
    const R = c.rotation, axes = [R.slice(0, 3), R.slice(3, 6), R.slice(6, 9)], T = c.translation;
    const eye = [0, 1, 2].map(k => -(R[k] * T[0] + R[3 + k] * T[1] + R[6 + k] * T[2]));
    return {right: axes[0], down: axes[1], forward: axes[2], eye, distance: distanceTo(eye, axes[2]), lens: c};
  };
  // To what is turned about: the point of the line of sight that is nearest to the scene's middle.
  const distanceTo = (eye, forward) => Math.max(header.size * 0.1, dot(forward, plus(header.middle, eye, -1)));
  const target = () => plus(camera.eye, camera.forward, camera.distance);
  function own() { if (seen.value !== "own") seen.value = "own"; changed(); }
  function orbit(dx, dy) {
    const at = target();
    for (const [axis, angle] of [[up, -dx], [camera.right, dy]]) {
      if (axis !== up) {  // not over the top
        const tilt = Math.acos(Math.max(-1, Math.min(1, dot(camera.forward, up)))), next = tilt + angle;
        if (next < 0.05 || next > Math.PI - 0.05) continue;
      }
      for (const name of ["right", "down", "forward"]) camera[name] = unit(turned(camera[name], axis, angle));
    }
    camera.eye = plus(at, camera.forward, -camera.distance);
    own();
  }
  function zoom(factor) {
    const at = target();
    camera.distance = Math.min(header.size * 20, Math.max(header.size * 0.05, camera.distance * factor));
    camera.eye = plus(at, camera.forward, -camera.distance);
    own();
  }
  function pan(dx, dy) {  // CSS pixels
    const k = camera.distance / (camera.lens.fx * fit().scale);
    camera.eye = plus(plus(camera.eye, camera.right, -dx * k), camera.down, -dy * k);
    own();
  }
  function lookFrom(name) {
    if (name === "own") return changed();
    camera = videoCamera(header.frames[Math.round(state.time)]);
    if (name !== "video") {
      let forward = header.front;
      if (name === "side") forward = turned(forward, up, Math.PI / 2);
      if (name === "back") forward = forward.map(x => -x);
      const right = unit(cross(forward, up));
      if (name === "top") forward = unit(plus(up.map(x => -x), forward, 0.02));
      camera = {...camera, forward, right, down: cross(forward, right)};
      camera.distance = header.size * 1.1 * camera.lens.fx / Math.min(camera.lens.width, camera.lens.height);
      camera.eye = plus(header.middle, forward, -camera.distance);
    }
    changed();
  }
  // How the camera's picture lies in the canvas.
  function fit() {
    const scale = Math.min(canvas.width / camera.lens.width, canvas.height / camera.lens.height);
    return {scale, x: (canvas.width - scale * camera.lens.width) / 2, y: (canvas.height - scale * camera.lens.height) / 2};
  }

  // --- Drawing
  function changed() { state.dirty = true; }
  function alone(r) {
    state.alone = r;
    chips.forEach((chip, k) => aria(chip, "pressed", String(k === r)));
    fillTable();
    changed();
  }
  function fillTable() {
    const data = new Float32Array(8 * rows.length);
    rows.forEach((row, r) => {
      data.set([...row.color, state.alone < 0 || state.alone === r ? 1 : 0], 4 * r);
      data[4 * (rows.length + r)] = row.modulus || 0;
    });
    if (tableTexture) gl.deleteTexture(tableTexture);
    tableTexture = texture(gl.RGBA32F, rows.length, 2, gl.RGBA, gl.FLOAT, data);
  }
  function onGpu(t, other) {
    let slot = held.find(h => h.t === t);
    if (slot) return slot.texture;
    slot = held.find(h => h.t !== other);
    const began = performance.now();
    if (!slot.texture) {
      slot.texture = texture(gl.RGBA16I, 768, lines, gl.RGBA_INTEGER, gl.SHORT, frames[t]);
    } else {
      gl.bindTexture(gl.TEXTURE_2D, slot.texture);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 768, lines, gl.RGBA_INTEGER, gl.SHORT, frames[t]);
    }
    slot.t = t;
    statistics.upload.push(performance.now() - began);
    return slot.texture;
  }
  const dark = () => matchMedia("(prefers-color-scheme: dark)").matches;
  function groundColour() {
    return ground.value === "white" ? [1, 1, 1] : ground.value === "grey" ? [0.5, 0.5, 0.5] : ground.value === "black" ? [0, 0, 0]
      : dark() && !header.exact ? [0.11, 0.115, 0.125] : header.background;
  }
  // Values of the colour scale's upper end: what 98 of 100 Gaussians stay below in the frames that are there.
  function scaleEnd(kind) {
    const key = kind + ":" + state.loaded;
    if (lights[key]) return lights[key];
    const values = [], pick = Math.max(1, Math.floor(header.gaussians / 2000)), F = new Float64Array(9), d = header.steps.deformation;
    for (let t = 0; t < state.loaded; t += 3) {
      const a = frames[t], b = frames[Math.min(t + 1, state.loaded - 1)];
      for (let i = 0; i < header.gaussians; i += pick) {
        const k = 12 * i;
        if (a[k + 3] === -32768) continue;
        if (kind === 2) {
          const seconds = times[Math.min(t + 1, frameCount - 1)] - times[t] || 1;
          values.push(header.steps.position * Math.hypot(b[k] - a[k], b[k + 1] - a[k + 1], b[k + 2] - a[k + 2]) / seconds);
          continue;
        }
        for (let c = 0; c < 9; ++c) F[c] = d * a[k + 3 + c] + (c % 4 === 0 ? 1 : 0);
        let sum = 0, trace = 0;
        const E = [];
        for (let r = 0; r < 3; ++r) for (let c = 0; c < 3; ++c)
          E.push(0.5 * (F[r] * F[c] + F[3 + r] * F[3 + c] + F[6 + r] * F[6 + c] - (r === c ? 1 : 0)));
        trace = kind === 4 ? (E[0] + E[4] + E[8]) / 3 : 0;
        E.forEach((e, n) => sum += (n % 4 === 0 ? e - trace : e) ** 2);
        values.push(Math.sqrt(sum) * (kind === 4 ? rows[rowsOf[i]].modulus || 0 : 1));
      }
    }
    values.sort((x, y) => x - y);
    return lights[key] = Math.max(values[Math.floor(0.98 * values.length)] || 0, 1e-9);
  }
  let rowsOf;
  const plain = x => x >= 1e6 ? (x / 1e6).toPrecision(2) + " M" : x >= 1e3 ? (x / 1e3).toPrecision(2) + " k" : x >= 100 ? x.toFixed(0) : x.toPrecision(2);
  function showLegend(kind, end) {
    legend.hidden = kind < 2;
    if (kind < 2) return;
    const text = kind === 2 ? `${plain(end)} units/s` : kind === 3 ? plain(end) : `${plain(end)}Pa`;
    const name = kind === 2 ? "Speed" : kind === 3 ? "Strain" : "Shear stress, estimated";
    const key = name + text;
    if (legend.dataset.key === key) return;
    legend.dataset.key = key;
    legend.replaceChildren($("span", {textContent: name}), $("i"), $("b", {textContent: "0"}), $("b", {textContent: text}));
  }

  function setSplats(view, size, focal, middle, extra = {}) {
    const u = splats.places;
    gl.useProgram(splats.made);
    gl.uniform2f(u.steps, header.steps.position, header.steps.deformation);
    gl.uniform1f(u.harmonicStep, header.steps.harmonics);
    gl.uniformMatrix3fv(u.turn, true, [...view.right, ...view.down, ...view.forward]);
    gl.uniform3fv(u.eye, view.eye);
    gl.uniform2fv(u.size, size);
    gl.uniform2fv(u.focal, focal);
    gl.uniform2fv(u.middle, middle);
    gl.uniform1f(u.near, extra.near ?? header.near);
    gl.uniform1i(u.degree, extra.degree ?? header.sh_degree);
    gl.uniform1f(u.largest, header.size / 260);
    gl.uniform4fv(u.flatten, extra.flatten ?? [0, 0, 0, 0]);
    const t = Math.min(frameCount - 1, Math.floor(state.time)), next = Math.min(t + 1, frameCount - 1), blend = state.time - t;
    const kind = extra.flatten ? 0 : Number(colours.value), end = kind > 1 ? scaleEnd(kind) : 1;
    if (!extra.flatten) showLegend(kind, end);
    gl.uniform1f(u.blend, blend);
    gl.uniform1f(u.seconds, extra.softness ?? (times[next] - times[t] || 1));
    gl.uniform1f(u.quickest, end);
    gl.uniform1i(u.colours, extra.flatten ? 1 : kind);
    gl.uniform1i(u.dots, pressed(dots) && !extra.flatten ? 1 : 0);
    const textures = {shape: shapeTexture, before: onGpu(t, next), after: onGpu(next, t), harmonics: harmonicsTexture, rowOf: rowTexture, rowTable: tableTexture};
    Object.entries(textures).forEach(([name, made], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, made);
      gl.uniform1i(u[name], unit);
    });
    gl.activeTexture(gl.TEXTURE0);
  }
  function drawSplats() {
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(cells);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, header.gaussians);
    gl.bindVertexArray(null);
  }
  function drawFloor(size, focal, middle) {
    const normal = header.floor.normal, reach = header.size * 1.6;
    const along = unit(Math.abs(dot(normal, header.front)) < 0.9 ? plus(header.front, normal, -dot(normal, header.front)) : cross(normal, [0.3, 0.5, 0.8]));
    const aside = cross(normal, along), offset = dot(normal, header.floor.point);
    const centre = plus(header.middle, normal, offset - dot(normal, header.middle));
    // From far above, so that it is as good as parallel.
    const far = 200 * reach, f = SHADOW / 2 * 200;
    gl.bindFramebuffer(gl.FRAMEBUFFER, shadowTarget);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    setSplats({right: along, down: aside.map(x => -x), forward: normal.map(x => -x), eye: plus(centre, normal, far)}, [SHADOW, SHADOW], [f, f],
      [SHADOW / 2, SHADOW / 2], {near: 0.001, degree: 0, flatten: [...normal, offset], softness: header.size * 0.25});
    drawSplats();
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    const u = plane.places;
    gl.useProgram(plane.made);
    gl.uniformMatrix3fv(u.turn, true, [...camera.right, ...camera.down, ...camera.forward]);
    for (const [name, value] of [["eye", camera.eye], ["normal", normal], ["middlePoint", centre], ["alongU", along], ["alongV", aside], ["ground", groundColour()]])
      gl.uniform3fv(u[name], value);
    gl.uniform2fv(u.size, size);
    gl.uniform2fv(u.focal, focal);
    gl.uniform2fv(u.middle, middle);
    gl.uniform1f(u.reach, reach);
    gl.bindTexture(gl.TEXTURE_2D, shadowTexture);
    gl.uniform1i(u.shadow, 0);
    gl.bindVertexArray(empty);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.bindVertexArray(null);
  }

  function draw() {
    const began = performance.now();
    const {scale, x, y} = fit(), size = [canvas.width, canvas.height], lens = camera.lens;
    const focal = [lens.fx * scale, lens.fy * scale], middle = [lens.cx * scale + x, lens.cy * scale + y];
    const [r, g, b] = groundColour();
    gl.viewport(0, 0, ...size);
    gl.disable(gl.BLEND);
    gl.clearColor(r, g, b, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    if (pressed(floor) && header.floor) drawFloor(size, focal, middle);
    setSplats(camera, size, focal, middle);
    drawSplats();
    statistics.draw.push(performance.now() - began);
  }

  // --- Time
  function resize() {
    const ratio = Math.min(2, devicePixelRatio || 1), box = canvas.getBoundingClientRect();
    const width = Math.max(1, Math.round(box.width * ratio)), height = Math.max(1, Math.round(box.height * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; changed(); }
  }
  const nearest = () => Math.min(state.loaded - 1, Math.round(state.time));
  // Asks for an order where view or frame are others than those of the last one.
  function order() {
    const key = nearest() + ":" + camera.forward.map(x => x.toFixed(5)).join();
    if (state.waiting || state.sorted === key) return state.sorted === key;
    state.waiting = key;
    worker.postMessage({kind: "sort", t: nearest(), axis: camera.forward, id: key});
    return false;
  }
  let lastTick = 0, hold = 0;
  function tick(now) {
    const passed = Math.min(0.25, (now - lastTick) / 1000);
    lastTick = now;
    if (state.playing && state.loaded > 0) {
      if (state.time >= frameCount - 1) {
        hold += passed;
        if (hold > 0.8) { state.time = 0; hold = 0; changed(); }
      } else {
        const t = Math.floor(state.time), seconds = times[t + 1] - times[t] || 0.04;
        state.time = Math.min(state.loaded - 1, state.time + passed * Number(speed.value) / seconds);
        hold = 0;
        changed();
      }
    }
    if (root.offsetParent !== null || root === document.body) {
      resize();
      if (seen.value === "video" && header.cameras.length > 1) camera = videoCamera(header.frames[nearest()] ?? 0);
      if (state.loaded > 0 && (state.dirty || state.sorted === null)) {
        order();
        if (state.sorted !== null) {
          state.dirty = false;
          draw();
          state.drawn = state.time;
          scrub.value = state.time;
          aria(scrub, "valuetext", `${shownTime()} seconds`);
          clock.textContent = `${shownTime()} s`;
        }
      }
    }
    requestAnimationFrame(tick);
  }
  function shownTime() {
    const t = Math.floor(state.time), next = Math.min(t + 1, frameCount - 1);
    return (times[t] + (state.time - t) * (times[next] - times[t])).toFixed(2);
  }
  function setPlaying(on) {
    state.playing = on;
    if (on && state.time >= frameCount - 1) state.time = 0;
    play.classList.toggle("v-playing", on);
    aria(play, "label", on ? "Pause" : "Play");
  }
  function seek(time) {
    state.time = Math.max(0, Math.min(state.loaded - 1, time));
    hold = 0;
    changed();
  }
  play.addEventListener("click", () => setPlaying(!state.playing));
  scrub.addEventListener("input", () => { setPlaying(false); seek(Number(scrub.value)); });
  full.addEventListener("click", () => document.fullscreenElement ? document.exitFullscreen() : root.requestFullscreen?.());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
  new ResizeObserver(changed).observe(canvas);

  // --- Hands
  const fingers = new Map();
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", event => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const now = [event.clientX, event.clientY], dx = now[0] - last[0], dy = now[1] - last[1], box = canvas.getBoundingClientRect();
    const ratio = canvas.width / box.width;
    if (fingers.size === 1) {
      if (event.shiftKey || event.buttons & 6) pan(dx * ratio, dy * ratio);
      else orbit(dx * Math.PI / box.width * 1.5, dy * Math.PI / box.height);
    } else if (fingers.size === 2) {
      const other = [...fingers.entries()].find(([id]) => id !== event.pointerId)[1];
      const spread = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
      zoom(spread(last, other) / spread(now, other));
      pan(dx * ratio / 2, dy * ratio / 2);
    }
    fingers.set(event.pointerId, now);
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, event => fingers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  // In a longer page the wheel scrolls it, unless the viewer is in use.
  canvas.addEventListener("wheel", event => {
    if (!header.whole && document.activeElement !== canvas && !document.fullscreenElement) return;
    event.preventDefault();
    zoom(Math.exp(Math.max(-0.3, Math.min(0.3, event.deltaY * 0.001))));
  }, {passive: false});
  canvas.addEventListener("dblclick", () => { seen.value = "video"; lookFrom("video"); });
  const keys = {
    " ": () => setPlaying(!state.playing), k: () => setPlaying(!state.playing),
    ArrowRight: () => { setPlaying(false); seek(Math.floor(state.time) + 1); },
    ArrowLeft: () => { setPlaying(false); seek(Math.ceil(state.time) - 1); },
    Home: () => seek(0), End: () => seek(frameCount - 1),
    a: () => orbit(0.1, 0), d: () => orbit(-0.1, 0), w: () => orbit(0, 0.08), s: () => orbit(0, -0.08),
    "+": () => zoom(0.9), "=": () => zoom(0.9), "-": () => zoom(1.11), r: () => { seen.value = "video"; lookFrom("video"); },
    c: () => { colours.selectedIndex = (colours.selectedIndex + 1) % colours.options.length; changed(); },
    b: () => { ground.selectedIndex = (ground.selectedIndex + 1) % ground.options.length; changed(); },
    p: () => dots.click(), f: () => floor.click(), 0: () => alone(-1)
  };
  (header.whole ? document : root).addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(SELECT|INPUT)$/.test(event.target.tagName)) return;
    if (event.key === " " && event.target.tagName === "BUTTON") return;
    const row = Number(event.key) - 1;
    if (row >= 0 && row < rows.length) alone(state.alone === row ? -1 : row);
    else if (keys[event.key]) keys[event.key]();
    else return;
    event.preventDefault();
  });

  // --- The stream
  function bytesOf(text) {
    const size = 1 << 20, parts = [];  // a multiple of four characters
    let total = 0;
    for (let at = 0; at < text.length; at += size) {
      const plainText = atob(text.slice(at, at + size)), part = new Uint8Array(plainText.length);
      for (let k = 0; k < part.length; ++k) part[k] = plainText.charCodeAt(k);
      parts.push(part);
      total += part.length;
    }
    const bytes = new Uint8Array(total);
    let at = 0;
    for (const part of parts) { bytes.set(part, at); at += part.length; }
    return bytes;
  }
  const address = URL.createObjectURL(new Blob([`(${viewerWorker})()`], {type: "text/javascript"}));
  const worker = new Worker(address);
  worker.onerror = event => fail("The viewer's worker failed: " + (event.message || "it could not be started"));
  worker.onmessage = event => {
    const message = event.data;
    if (message.kind === "error") fail("The stream cannot be read: " + message.text);
    if (message.kind === "rest") {
      lines = message.lines;
      shapeTexture = texture(gl.RGBA32F, 1024, lines, gl.RGBA, gl.FLOAT, message.shape);
      harmonicsTexture = header.sh_degree ? texture(gl.RGBA8I, 3840, lines, gl.RGBA_INTEGER, gl.BYTE, message.harmonics)
        : texture(gl.RGBA8I, 1, 1, gl.RGBA_INTEGER, gl.BYTE, message.harmonics);
      rowsOf = message.row;
      rowTexture = texture(gl.R16UI, 256, lines, gl.RED_INTEGER, gl.UNSIGNED_SHORT, message.row);
      fillTable();
    }
    if (message.kind === "frame") {
      frames[message.t] = message.values;
      state.loaded = message.t + 1;
      statistics.decode.push(message.milliseconds);
      if (state.loaded === frameCount) {
        word.hidden = true;
        URL.revokeObjectURL(address);
        if (!matchMedia("(prefers-reduced-motion: reduce)").matches && header.whole && !bare) setPlaying(true);
        changed();
      } else {
        word.textContent = `Loading ${Math.round(100 * state.loaded / frameCount)} %`;
      }
    }
    if (message.kind === "order") {
      gl.bindBuffer(gl.ARRAY_BUFFER, indices);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, message.order);
      statistics.sort.push(message.milliseconds);
      state.sorted = message.id;
      state.waiting = false;
      changed();
    }
  };
  // For pictures and tests: #bare is the canvas alone in the video's size and background, paused at the first frame.
  const bare = header.whole && location.hash.startsWith("#bare");
  if (bare) {
    root.classList.add("v-bare");
    header.exact = true;
    Object.assign(canvas.style, {width: header.cameras[0].width + "px", height: header.cameras[0].height + "px"});
  }
  if (!header.floor) floor.hidden = true;
  else if (header.floor.shown && !bare) aria(floor, "pressed", "true");
  lookFrom("video");
  const bytes = bytesOf(base64);
  worker.postMessage({kind: "start", header, bytes}, [bytes.buffer]);
  requestAnimationFrame(tick);

  // Whether what is on the screen is what was asked for, in its order.
  const settled = () => state.loaded === frameCount && !state.dirty && !state.waiting && order() && state.drawn === state.time;
  return {state, statistics, canvas, seek, setPlaying, orbit, zoom, pan, alone, lookFrom, settled, camera: () => camera};
}
